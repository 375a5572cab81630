# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A link: one direction of a network, with the effects that its settings switch on. A packet is
lost on entry, or copied; it and its copies leave, wait for their delay and come out. Payloads are
never looked into. Time is an argument [ns]. Plug-ins come after the library in each step, but
before the order of packets.
"""

from collections.abc import Sequence
from functools import partial
from types import SimpleNamespace
from typing import Any

from pmwvc_core.network.delay_trace import LOST, recording_of
from pmwvc_core.network.distributions import Distribution, drawn
from pmwvc_core.network.draws import Draws, Losses
from pmwvc_core.network.effects import check, plugins_of
from pmwvc_core.network.effects.library import LIBRARY
from pmwvc_core.network.effects.record import HOOKS, Effect, contained
from pmwvc_core.network.in_flight import Cause, Fate, FateKind, InFlight
from pmwvc_core.network.presets import timeline_of
from pmwvc_core.network.queues import Order, SerialLine, Slots
from pmwvc_core.params import LinkParams
from pmwvc_core.plugins import refused

COPIED = (FateKind.DUPLICATE, Cause.DUPLICATION)


class Link(InFlight):
    """One direction of a network link: ``direction`` 0 up, 1 down. Its random numbers are those of
    the seed (of the session, number of the user, direction). What a part remembers stays when it
    is switched off.
    """

    def __init__(
        self, params: LinkParams, *, seed: int | Sequence[int], direction: int = 0
    ) -> None:
        super().__init__()
        self._direction = direction
        self._draws = Draws(seed)
        self._losses = Losses(self._draws)
        self._line, self._order = SerialLine(), Order()
        self._slots = Slots(partial(self._draws.nth, "slots"))
        self._made: dict[str, Effect] = {}  # plug-ins by name
        self._begin_ns: int | None = None
        self.configure(params)

    def configure(self, params: LinkParams) -> None:
        """Change the settings from now on; PmwvcError if unusable: the old ones stay."""
        check(params)
        timeline = timeline_of(params.schedule)
        steps = [entry.applied(params, self._direction) for entry in timeline.entries]
        for step in steps:  # loading a distribution may take 0.3 s: no packet waits for that
            if law := drawn(step):
                law.at(step, 0.5)
        self._take(steps[0])
        self.params = params
        self._timeline, self._steps, self._step = timeline, steps, 0

    def _take(self, params: LinkParams) -> None:
        """Work by these settings from now on."""
        effects = {}
        for record in plugins_of(params.effects):
            name, made = record.name, self._made.get(record.name)
            if made is None:  # configured as it is made
                with refused(f"effects: {name}"):
                    made = record.make(params, partial(self._draws.each, name))
                self._made[name] = made
                made.begin_ns = self._begin_ns or 0
            else:
                self.faults.guarded(partial(made.configure, params), None, name)
            effects[name] = made
        self._hooks = {
            hook: [
                contained(effect, name, hook, self.faults)
                for name, effect in effects.items()
                if getattr(type(effect), hook) is not getattr(Effect, hook)
            ]
            for hook in HOOKS
        }
        self._now = params
        self._on = SimpleNamespace(**{each.name: each.active(params) for each in LIBRARY})
        self._jitter: Distribution | None = drawn(params)
        self._trace = recording_of(params) if self._on.trace else None
        self._order.begin()
        self._line.begin()

    def send(self, payload: Any, now_ns: int, *, size_bytes: int = 140) -> list[Fate]:
        """Put a packet in; return its fate, and one for every extra copy."""
        if self._begin_ns is None:
            self._begin_ns = now_ns
            for effect in self._made.values():
                effect.begin_ns = now_ns
        elapsed_ns = now_ns - self._begin_ns
        ramp_s, outage = 0.0, False
        if self.params.schedule:
            step, part = self._timeline.at(elapsed_ns)
            if step != self._step:
                self._step = step
                self._take(self._steps[step])
            entry = self._timeline.entries[step]
            outage = entry.outage
            ramp_s = (entry.ramp_s[1] - entry.ramp_s[0]) * part if entry.ramp_s else 0.0
        recorded_ns = self._trace.at(elapsed_ns) if self._trace else 0
        p, on, draws, losses = self._now, self._on, self._draws, self._losses
        number = self.counters.in_count = self.counters.in_count + 1
        luck = draws.four()
        fate = Fate(number, now_ns, size=size_bytes)
        lost: Cause | bool = False
        for cause in (  # all are asked: each draws the same in any company
            on.loss and draws.correlated("loss", fate, luck[0], p.loss_correlation) < p.loss,
            on.gilbert_elliott and losses.by_two_states(p, fate),
            on.handover and losses.by_hand_over(p, fate, elapsed_ns),
            outage and Cause.OUTAGE,
            recorded_ns == LOST,
        ):
            lost = lost or cause
        for loses in self._hooks["loses"]:
            cause = loses(fate)
            lost = lost or cause
        if lost:
            self.counters.lost += 1
            fate.kind = FateKind.LOST
            fate.cause = lost if isinstance(lost, Cause) else Cause.LOSS
            return [fate]
        step_s = losses.step_s(p, elapsed_ns) if on.handover else 0.0
        delay_s = step_s + p.delay_s + ramp_s
        fates = [self._travel(payload, fate, luck, delay_s, recorded_ns)]
        if on.duplication:
            u = draws.correlated("duplication", fate, luck[1], p.duplicate_correlation)
            if u < p.duplicate:
                copy = Fate(number, now_ns, 0, *COPIED, size_bytes, copy=1)
                fates.append(self._travel(payload, copy, luck, delay_s, recorded_ns))
        return fates

    def _travel(
        self, payload: Any, fate: Fate, luck: list[float], delay_s: float, recorded_ns: int
    ) -> Fate:
        """Send a packet or copy on its way, or drop it; ``delay_s`` without jitter."""
        p, on, draws, hooks = self._now, self._on, self._draws, self._hooks
        ready_ns: int | None = fate.time_in_ns
        if on.rate_limit:
            ready_ns = self._line.departs_ns(p, fate, fate.time_in_ns)
        if ready_ns is None:
            self.counters.dropped += 1
            fate.kind, fate.cause = FateKind.DROPPED_QUEUE, Cause.QUEUE_FULL
            return fate
        if on.corruption:
            u = draws.of("corruption", fate)
            u = draws.correlated("corruption", fate, u, p.corrupt_correlation)
            if u < p.corrupt:
                fate.cause, fate.flip = Cause.CORRUPTION, draws.of("corruption", fate, 1)
        at_once = False
        if on.reordering:
            u = draws.of("reordering", fate)
            u = draws.correlated("reordering", fate, u, p.reorder_correlation)
            at_once = u < p.reorder
        if self._jitter is not None:
            u = draws.correlated(p.jitter, fate, luck[2 + fate.copy], p.jitter_correlation)
            delay_s += float(self._jitter.at(p, u))
        for hook in hooks["delay_s"]:
            delay_s += hook(fate)
        due_ns = ready_ns + (0 if at_once else max(0, round(delay_s * 1e9))) + recorded_ns
        if on.slots:
            due_ns = self._slots.arrives_ns(p, fate, due_ns, self._begin_ns or 0)
        for hook in hooks["arrives_ns"]:
            due_ns = hook(fate, due_ns)
        self._enter(payload, fate, self._order.arrives_ns(p, fate, due_ns))
        return fate
