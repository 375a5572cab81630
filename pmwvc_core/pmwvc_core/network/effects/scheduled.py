# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The timeline of a link at work: outages, and ramps of the delay.

The other settings of its entries are the link's to take: :mod:`pmwvc_core.network.link`.
"""

from pmwvc_core.errors import refusal
from pmwvc_core.network.effects.record import Effect, LinkEffect
from pmwvc_core.network.in_flight import Cause, Fate
from pmwvc_core.network.timeline import timeline_of
from pmwvc_core.params import LinkParams


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


RECORD = LinkEffect(
    name="schedule",
    words="Settings change on a timeline.",
    linear="delay",
    make=Scheduled,
    parameters=("schedule",),
    active=lambda params: bool(params.schedule.strip()),
    spreads=True,
    amount=lambda params: f"a timeline ({params.schedule})",
    label=lambda params: "timeline",
    off="",
    conflict=lambda params: refusal(timeline_of, params.schedule),
    check=lambda params: timeline_of(params.schedule),
)
