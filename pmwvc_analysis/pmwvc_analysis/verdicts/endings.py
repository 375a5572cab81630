# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The nodes that ended before the session did, and the time until which it is judged.

A server or an emulator that ended takes the loop with it: everything is judged up to there. A
master that ended takes its user with it alone; a user who left interrupts nothing.

The end of a node is reported by the session runner where it saw that, else by its trace, which
breaks off while others go on.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from pmwvc_analysis.events.nodes import Event
from pmwvc_analysis.recording.content import CUT
from pmwvc_analysis.recording.topics import relayed
from pmwvc_analysis.traces.stages import disturbances, until
from pmwvc_analysis.traces.thresholds import EARLY_S, LEAVING_S
from pmwvc_core.frame import Presence
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces


class Ending(NamedTuple):
    """A node that ended early: ``user`` is its user's name, empty for a node of everybody's."""

    who: str
    user: str
    time_s: float
    what: str
    interrupts: bool = True  # False: the user left, or the scenario asked for it

    @property
    def text(self) -> str:
        """The ending in words."""
        return f"{self.who} {self.what} at {self.time_s:.2f} s"


def endings(traces: SessionTraces, events: list[Event], scenario: Scenario | None) -> list[Ending]:
    """Return what ended before the end of the session, earliest first."""
    early_s, found = session_end_s(traces, scenario) - EARLY_S, []
    ended = [e for e in events if e["kind"] == "ended" and (e["time_s"] or math.inf) < early_s]
    noted = {str(each["who"]): each for each in reversed(ended)}
    left_s = {e["who"]: float(e["time_s"]) for e in events if e["kind"] == "leave"}
    soon_s = max(LEAVING_S, 2.0 * traces.server.period_s) if traces.server is not None else 0.0
    killed = {who for who, action, _ in disturbances(traces) if action == "kill"}
    for who, user, last_s in _nodes(traces):
        end, gone = noted.get(who), last_s <= early_s
        if gone and user and abs(left_s.get(user, math.inf) - last_s) <= soon_s:
            found.append(Ending(user, user, last_s, "left", interrupts=False))
        elif end or gone:  # a runner sees an end a little later than the last that is on record
            what = str(end["what"]) if end else "was last recorded"
            what = "was killed, as asked," if who in killed else what
            time_s = min(last_s, float(end["time_s"])) if end else last_s
            found.append(Ending(who, user, time_s, what, interrupts=who not in killed))
    return sorted(found, key=lambda ending: ending.time_s)


def _nodes(traces: SessionTraces) -> Iterator[tuple[str, str, float]]:
    """Yield the nodes on record, whose they are (empty: everybody's), and until when each was
    recorded [s]; the emulator is by the packets that came in, each for the time it stands for.
    """
    for user in traces.users:
        yield f"{user.name} master", user.name, float(user.time_s[-1]) + user.tick_s
    if (server := traces.server) is not None and len(server.time_s):
        yield "server", "", float(server.time_s[-1] + server.periods_s[-1])
    came = [each.time_s for topic, each in traces.packets.items() if relayed(topic)]
    zeros = traces.metadata.get("fate_zero_ns", {})
    for link, fates in traces.fates.items():
        came.append(1e-9 * (fates.time_in_ns - zeros.get(link, 0)))
    due_s = max((each.period_s.max(initial=0.0) for each in traces.packets.values()), default=0.0)
    if last_s := max((float(each.max(initial=0.0)) for each in came), default=0.0):
        yield "netem", "", last_s + due_s


def session_end_s(traces: SessionTraces, scenario: Scenario | None) -> float:
    """Return when the session was over: the last tick of any user, or what outlived them all."""
    end_s, server = traces.duration_s, traces.server
    if server is not None:
        there = [server.time_s[state != Presence.ABSENT] for state in server.state]
        end_s = max([end_s, *(float(each[-1]) for each in there if len(each))])
    return end_s if scenario is None else min(end_s, max(scenario.duration_s, traces.duration_s))


def judged(traces: SessionTraces, found: list[Ending]) -> SessionTraces:
    """Return what is judged of a session: until a node that everybody needs ended, or the end."""
    ends_s = (ending.time_s for ending in found if not ending.user)
    return until(traces, min([traces.duration_s, *ends_s]))


def shortened(traces: SessionTraces, scenario: Scenario | None) -> str:
    """Return in words by how much a session or its record is shorter than its scenario, if so."""
    cut = next((str(each["what"]) for each in traces.events if each["kind"] == CUT), "")
    if scenario is None or traces.source == "simulated":
        return cut
    if (end_s := session_end_s(traces, scenario)) > scenario.duration_s - EARLY_S:
        return ""
    length = f"{end_s:.1f} of {scenario.duration_s:g} s"
    return f"{cut}: {length} are on record" if cut else f"the session ended after {length}"
