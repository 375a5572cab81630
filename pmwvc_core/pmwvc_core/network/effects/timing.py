# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The delay of a link, its timeline (outages and ramps of the delay), and the order of packets.

A timeline's other settings are taken by :mod:`pmwvc_core.network.link`.
"""

from pmwvc_core.errors import refusal
from pmwvc_core.network.effects.queues import Drain
from pmwvc_core.network.effects.record import (
    Effect,
    LinkEffect,
    Uniform,
    linux_effect,
    made_of,
)
from pmwvc_core.network.in_flight import Cause, Fate
from pmwvc_core.network.timeline import timeline_of
from pmwvc_core.params import LinkParams

DELAY = linux_effect(
    name="delay",
    words="Every packet takes the same time.",
    make=made_of(delay_s=lambda effect, fate: float(effect.params.delay_s)),
    random=False,
    label=lambda params: f"{float(params.delay_s * 1e3):.4g} ms",
    mean_s=lambda params: float(params.delay_s),
)


class Scheduled(Effect):
    """Lose everything in an outage; add what a ramp has reached."""

    def configure(self, params: LinkParams) -> None:
        """Read the timeline."""
        super().configure(params)
        self._timeline = timeline_of(params.schedule)

    def loses(self, fate: Fate) -> Cause | bool:
        """Tell whether there is an outage."""
        number, _ = self._timeline.at(fate.time_in_ns - self.begin_ns)
        return self._timeline.entries[number].outage and Cause.OUTAGE

    def delay_s(self, fate: Fate) -> float:
        """Return by how much a ramp is beyond its beginning [s]."""
        number, part = self._timeline.at(fate.time_in_ns - self.begin_ns)
        ramp_s = self._timeline.entries[number].ramp_s
        return (ramp_s[1] - ramp_s[0]) * part if ramp_s else 0.0


SCHEDULE = LinkEffect(
    name="schedule",
    words="Settings change on a timeline.",
    linear="delay",
    make=Scheduled,
    active=lambda params: bool(params.schedule.strip()),
    spreads=True,
    amount=lambda params: f"a timeline ({params.schedule})",
    label=lambda params: "timeline",
    conflict=lambda params: refusal(timeline_of, params.schedule),
    check=lambda params: timeline_of(params.schedule),
)


class Order(Effect):
    """Keep the order of packets where ``keep_order`` is set, also against earlier settings."""

    def __init__(self, params: LinkParams, uniform: Uniform) -> None:
        self._drain = Drain()
        self._latest_ns = 0  # of all that came in
        super().__init__(params, uniform)

    def configure(self, params: LinkParams) -> None:
        """Take other settings; packets of earlier ones may wait."""
        super().configure(params)
        self._drain.begin()

    def arrives_ns(self, fate: Fate, due_ns: int) -> int:
        """Return the time of the latest packet before, or its turn after it, if that is later."""
        in_turn_ns = self._drain.in_turn_ns(fate.time_in_ns, self._latest_ns, due_ns)
        kept = self.params.keep_order
        latest_ns = self._latest_ns = max(in_turn_ns if kept else due_ns, self._latest_ns)
        return latest_ns if kept else due_ns


ORDER = linux_effect(
    name="order",
    words="A later packet waits for an earlier one.",
    linear="order",
    make=Order,
    random=False,
)
