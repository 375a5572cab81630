# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The events of a session in the order of time, numbered: the same numbers in list and figures."""

from typing import NamedTuple

from pmwvc_core.traces import SessionTraces

ALARMING = ("release", "stall", "limit", "stranger", "recording", "restart")


class Event(NamedTuple):
    """One event; ``time_s`` is None where it is not known."""

    number: str
    time_s: float | None
    who: str
    kind: str
    what: str

    @property
    def alarming(self) -> bool:
        """Tell whether the kind of event is a reason to look closer."""
        return self.kind in ALARMING


def numbered(traces: SessionTraces) -> list[Event]:
    """Return the events, those without a time first."""
    order = sorted(traces.events, key=lambda e: (e["time_s"] is not None, e["time_s"] or 0.0))
    return [
        Event(
            str(index),
            event["time_s"],
            str(event.get("who", "")),
            str(event.get("kind", "")),
            str(event.get("what", "")),
        )
        for index, event in enumerate(order, start=1)
    ]
