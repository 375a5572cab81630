# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A link: one direction of a network, with the effects that its settings switch on.

A packet is lost on entry, or copied; it and its copies leave, wait for their delay and come out.
Payloads are never looked into. Time is an argument; all times are integer nanoseconds of one
clock.
"""

import zlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_core.errors import PLUGIN_ERRORS
from pmwvc_core.network.effects import EFFECTS, Effect, LinkEffect, Uniform, active, check
from pmwvc_core.network.effects.contained import EffectFaults, contained
from pmwvc_core.network.in_flight import Cause, Fate, FateKind, InFlight
from pmwvc_core.params import LinkParams
from pmwvc_core.plugins import refused


def stream_of(seed: int, user: int, direction: int) -> tuple[int, int, int]:
    """Return the seed of one direction (0 up, 1 down) of one user's link: independent streams."""
    return seed, user, direction


class Link(InFlight):
    """One direction of a network link.

    Every packet takes the same four random numbers (lost?, copied?, jitter, jitter of the copy)
    whatever the settings: the n-th packet meets the same luck under any of them. An effect without
    an index among the four has a stream of its own, by the seed, its name and the number of the
    packet, so that it changes none of them.

    Parameters
    ----------
    params
        The settings.
    seed
        Of the random numbers; see :func:`stream_of`.
    """

    def __init__(self, params: LinkParams, *, seed: int | Sequence[int]) -> None:
        super().__init__()
        self._seed = (seed,) if isinstance(seed, int) else tuple(seed)
        self._rng = np.random.default_rng(seed)
        self._luck: list[float] = []  # the four numbers of the newest packet
        self.faults = EffectFaults()  # of plug-ins
        self._made: dict[str, Effect] = {}  # by name: each keeps its memory when switched off
        self._begin_ns: int | None = None
        self.configure(params)

    def configure(self, params: LinkParams) -> None:
        """Change the settings from now on; packets in flight keep their times.

        Raises
        ------
        PmwvcError
            If they cannot be used, as a delay trace whose file cannot be read; the settings stay.
        """
        check(params)
        effects = {}
        for record in active(params):
            if record.name not in self._made:
                self._made[record.name] = self._make(record, params)
                self._made[record.name].begin_ns = self._begin_ns or 0
            effects[record.name] = self._made[record.name]
        for name, effect in effects.items():
            try:
                effect.configure(params)
            except PLUGIN_ERRORS as error:
                if name in EFFECTS.library:
                    raise
                self.faults.note(name, error)
        self.params = params
        self._loses = self._hooks(effects, "loses")
        self._copies = self._hooks(effects, "copies")
        self._departs = self._hooks(effects, "departs_ns")
        self._delays = self._hooks(effects, "delay_s")
        self._arrives = self._hooks(effects, "arrives_ns")

    def _make(self, record: LinkEffect, params: LinkParams) -> Effect:
        with refused(f"effects: {record.name}"):
            return record.make(params, self._uniform(record))

    def _hooks(self, effects: Mapping[str, Effect], hook: str) -> list[Callable[..., Any]]:
        """Return a hook of the effects that have it; those of plug-ins contained."""
        return [
            getattr(effect, hook)
            if name in EFFECTS.library
            else contained(effect, name, hook, self.faults)
            for name, effect in effects.items()
            if getattr(type(effect), hook) is not getattr(Effect, hook)
        ]

    def _uniform(self, record: LinkEffect) -> Uniform:
        """Return the random numbers of an effect."""
        key, slot = (*self._seed, zlib.crc32(record.name.encode())), record.slot

        def own(fate: Fate, index: int = 0) -> float:
            stream = np.random.default_rng((*key, fate.number, fate.copy))
            return float(stream.random(index + 1)[index])

        def shared(fate: Fate, index: int = 0) -> float:
            if slot is None or index or fate.copy > 1:
                return own(fate, index)
            return self._luck[slot + fate.copy]

        return own if slot is None else shared

    def send(self, payload: Any, now_ns: int, *, size_bytes: int = 140) -> list[Fate]:
        """Put a packet in; return its fate, and one for every extra copy."""
        if self._begin_ns is None:
            self._begin_ns = now_ns
            for effect in self._made.values():
                effect.begin_ns = now_ns
        number = self.counters.in_count = self.counters.in_count + 1
        self._luck = self._rng.random(4).tolist()
        fate = Fate(number, now_ns, 0, FateKind.DELIVERED, Cause.NONE, size_bytes)
        for loses in self._loses:
            if loses(fate):
                self.counters.lost += 1
                fate.kind, fate.cause = FateKind.LOST, Cause.LOSS
                return [fate]
        fates = [self._travel(payload, fate)]
        for copies in self._copies:
            for _ in range(copies(fate)):
                self.counters.duplicated += 1
                kind, cause = FateKind.DUPLICATE, Cause.DUPLICATION
                copy = Fate(number, now_ns, 0, kind, cause, size_bytes, len(fates))
                fates.append(self._travel(payload, copy))
        return fates

    def _travel(self, payload: Any, fate: Fate) -> Fate:
        """Send a packet or copy on its way, or drop it."""
        ready_ns = fate.time_in_ns
        for departs_ns in self._departs:
            left_ns = departs_ns(fate, ready_ns)
            if left_ns is None:
                self.counters.dropped += 1
                fate.kind, fate.cause = FateKind.DROPPED_QUEUE, Cause.QUEUE_FULL
                return fate
            ready_ns = left_ns
        total_s = 0.0
        for delay_s in self._delays:
            total_s += delay_s(fate)
        due_ns = ready_ns + max(0, round(total_s * 1e9))
        for arrives_ns in self._arrives:
            due_ns = arrives_ns(fate, due_ns)
        self._enter(payload, fate, due_ns)
        return fate
