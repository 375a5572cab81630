# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A link: one direction of a network, with the effects that its settings switch on.

A packet is lost on entry, or copied; it and its copies leave, wait for their delay and come out.
Payloads are never looked into. Time is an argument; all times are integer nanoseconds of one
clock.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_core.errors import PLUGIN_ERRORS
from pmwvc_core.network.distributions import prepare
from pmwvc_core.network.effects import EFFECTS, Effect, LinkEffect, Uniform, active, check
from pmwvc_core.network.effects.record import ANSWERS, EffectFaults, contained
from pmwvc_core.network.in_flight import Cause, Fate, FateKind, InFlight
from pmwvc_core.network.streams import Stream
from pmwvc_core.network.timeline import Timeline, timeline_of
from pmwvc_core.params import LinkParams
from pmwvc_core.plugins import refused

COPIED = (FateKind.DUPLICATE, Cause.DUPLICATION)
TOGETHER = 256  # packets whose random numbers are drawn together


def stream_of(seed: int, user: int, direction: int) -> tuple[int, int, int]:
    """Return the seed of one direction (0 up, 1 down) of one user's link: independent streams."""
    return seed, user, direction


class Link(InFlight):
    """One direction of a network link.

    Every packet takes the same four random numbers (lost?, copied?, jitter, jitter of the copy)
    whatever the settings: the n-th packet meets the same luck under any of them. An effect without
    an index among the four has a stream of its own, by the seed, its name and the number of the
    packet, so that it changes none of them. The seed is that of :func:`stream_of`; the direction,
    for networks by name on a timeline, is 0 from user to server and 1 back.
    """

    def __init__(
        self, params: LinkParams, *, seed: int | Sequence[int], direction: int = 0
    ) -> None:
        super().__init__()
        self._seed = (seed,) if isinstance(seed, int) else tuple(seed)
        self._direction = direction
        self._rng = np.random.default_rng(seed)
        self._luck: list[float] = []  # the four numbers of the newest packet,
        self._drawn: list[list[float]] = []  # and those of the next ones, backwards
        self.faults = EffectFaults()  # of plug-ins
        self._made: dict[str, Effect] = {}  # by name: each keeps its memory when switched off
        self._begin_ns: int | None = None
        self.configure(params)

    def configure(self, params: LinkParams) -> None:
        """Change the settings from now on; packets in flight keep their times. PmwvcError where
        they cannot be used, as a delay trace whose file cannot be read; then the settings stay.
        """
        check(params)
        timeline: Timeline | None = timeline_of(params.schedule) if params.schedule else None
        steps = []
        if timeline is not None:
            steps = [entry.applied(params, self._direction) for entry in timeline.entries]
        for each in (params, *steps):
            prepare(each)
        self.params = params
        self._timeline, self._steps, self._step = timeline, steps, 0
        self._take(steps[0] if steps else params)

    def _take(self, params: LinkParams) -> None:
        """Have the effects work by these settings from now on."""
        effects = {}
        for record in active(params):
            name, made = record.name, self._made.get(record.name)
            if made is None:  # configured as it is made
                with refused(f"effects: {name}"):
                    made = self._made[name] = record.make(params, self._uniform(record))
                made.begin_ns = self._begin_ns or 0
            else:
                self._configure(name, made, params)
            effects[name] = made
        self._hooks = {hook: self._of(effects, hook) for hook in ANSWERS}

    def _configure(self, name: str, effect: Effect, params: LinkParams) -> None:
        try:
            effect.configure(params)
        except PLUGIN_ERRORS as error:
            if name in EFFECTS.library:
                raise
            self.faults.note(name, error)

    def _of(self, effects: Mapping[str, Effect], hook: str) -> list[Callable[..., Any]]:
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
        stream, slot = Stream(self._seed, record.name), record.slot

        def shared(fate: Fate, index: int = 0) -> float:
            if slot is None or index or fate.copy > 1:
                return stream.each(fate, index)
            return self._luck[slot + fate.copy]

        if slot is not None:
            return shared
        return stream if record.name in EFFECTS.library else stream.each

    def send(self, payload: Any, now_ns: int, *, size_bytes: int = 140) -> list[Fate]:
        """Put a packet in; return its fate, and one for every extra copy."""
        if self._begin_ns is None:
            self._begin_ns = now_ns
            for effect in self._made.values():
                effect.begin_ns = now_ns
        if self._timeline is not None:
            self._follow(self._timeline, now_ns - self._begin_ns)
        number = self.counters.in_count = self.counters.in_count + 1
        if not self._drawn:
            self._drawn = self._rng.random((TOGETHER, 4)).tolist()[::-1]
        self._luck = self._drawn.pop()
        fate = Fate(number, now_ns, size=size_bytes)
        lost: Cause | bool = False
        for loses in self._hooks["loses"]:  # all are asked: each draws the same in any company
            cause = loses(fate)
            lost = lost or cause
        if lost:
            self.counters.lost += 1
            fate.kind = FateKind.LOST
            fate.cause = lost if isinstance(lost, Cause) else Cause.LOSS
            return [fate]
        fates = [self._travel(payload, fate)]
        for copies in self._hooks["copies"]:
            for _ in range(copies(fate)):
                self.counters.duplicated += 1
                copy = Fate(number, now_ns, 0, *COPIED, size_bytes, len(fates))
                fates.append(self._travel(payload, copy))
        return fates

    def _follow(self, timeline: Timeline, elapsed_ns: int) -> None:
        """Take the settings of the timeline's entry that holds now."""
        step, _ = timeline.at(elapsed_ns)
        if step != self._step:
            self._step = step
            self._take(self._steps[step])

    def _travel(self, payload: Any, fate: Fate) -> Fate:
        """Send a packet or copy on its way, or drop it."""
        ready_ns = fate.time_in_ns
        for departs_ns in self._hooks["departs_ns"]:
            left_ns = departs_ns(fate, ready_ns)
            if left_ns is None:
                self.counters.dropped += 1
                fate.kind, fate.cause = FateKind.DROPPED_QUEUE, Cause.QUEUE_FULL
                return fate
            ready_ns = left_ns
        for corrupts in self._hooks["corrupts"]:
            if (fraction := corrupts(fate)) is not None:
                self.counters.corrupted += 1
                fate.cause, fate.flip = Cause.CORRUPTION, fraction
        at_once = False
        for hook in self._hooks["at_once"]:
            at_once = hook(fate) or at_once
        total_s = 0.0
        for delay_s in self._hooks["delay_s"]:
            total_s += delay_s(fate)
        due_ns = ready_ns + (0 if at_once else max(0, round(total_s * 1e9)))
        for arrives_ns in self._hooks["arrives_ns"]:
            due_ns = arrives_ns(fate, due_ns)
        self._enter(payload, fate, due_ns)
        return fate
