# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The nodes that ended before the session did, and the time until which it is judged.

A server or an emulator that ended takes the loop with it: everything is judged up to there. A
master that ended takes its user with it alone; a user who left interrupts nothing.

The end of a node is reported by the session runner where it saw that, else by its trace, which
breaks off while others go on. Where its packets go on, that is a hole of the recording.
"""

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

from pmwvc_analysis.events.nodes import Event
from pmwvc_analysis.recording.content import CUT
from pmwvc_analysis.recording.format.topics import relayed
from pmwvc_analysis.traces.thresholds import EARLY_S
from pmwvc_core.frame.rows import Presence
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

LOOP = ("server", "netem")  # nodes that everybody needs
KILL = ": kill"  # ends a disturbance that the scenario asks for


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
    end_s = session_end_s(traces, scenario)
    found: dict[str, Ending] = {}
    for each in events:
        who, time_s = str(each.get("who", "")), each["time_s"]
        user = who.removesuffix(" master") if who.endswith(" master") else ""
        ended = each["kind"] == "ended" and (user or who in LOOP)
        if ended and time_s is not None and time_s < end_s - EARLY_S:
            last_s = min(float(time_s), _last_s(traces, who))
            found.setdefault(who, Ending(who, user, last_s, str(each["what"])))
    for master in traces.users:
        name, last_s = master.name, float(master.time_s[-1]) + master.tick_s
        who, gone = f"{name} master", last_s <= end_s - EARLY_S
        if gone and _left(traces, name, last_s):
            found[who] = Ending(name, name, last_s, "left", interrupts=False)
        elif gone and who not in found:
            sent_s = _last_packet_s(traces, [f"/{name}/wave_up"])
            found[who] = _broken_off(who, name, last_s, sent_s)
    last_s = _last_s(traces, "server")
    if "server" not in found and last_s <= traces.duration_s - EARLY_S:
        sent = [topic for topic in traces.packets if re.fullmatch("/server/.*/wave_down", topic)]
        sent_s = _last_packet_s(traces, sent)
        found["server"] = _broken_off("server", "", last_s, sent_s)
    killed = {e["who"] for e in events if e["kind"] == "disturbance" and e["what"].endswith(KILL)}
    for who in killed & found.keys():
        found[who] = found[who]._replace(what="was killed, as asked,", interrupts=False)
    return sorted(found.values(), key=lambda ending: ending.time_s)


def _last_s(traces: SessionTraces, who: str) -> float:
    """Return when the last that a node of everybody's published is from [s]: a runner sees its end
    a little later. Infinity where nothing is.
    """
    if who == "server" and traces.server is not None and len(traces.server.time_s):
        return float(traces.server.time_s[-1] + traces.server.periods_s[-1])
    topics = [topic for topic in traces.packets if who == "netem" and relayed(topic)]
    return _last_packet_s(traces, topics) or math.inf


def _last_packet_s(traces: SessionTraces, topics: Iterable[str]) -> float:
    """Return when the last packet of some topics was recorded [s]; zero: there was none."""
    times = [traces.packets[topic].time_s for topic in topics if topic in traces.packets]
    return max((float(each[-1]) for each in times if len(each)), default=0.0)


def session_end_s(traces: SessionTraces, scenario: Scenario | None) -> float:
    """Return when the session was over: the last tick of any user, or what outlived them all."""
    end_s, server = traces.duration_s, traces.server
    if server is not None:
        there = [server.time_s[state != Presence.ABSENT] for state in server.state]
        end_s = max([end_s, *(float(each[-1]) for each in there if len(each))])
    return end_s if scenario is None else min(end_s, max(scenario.duration_s, traces.duration_s))


def _left(traces: SessionTraces, name: str, last_s: float) -> bool:
    """Tell whether a user took its leave, which is a change of membership."""
    server = traces.server
    if server is None or name not in server.users:
        return False
    after = server.state[server.users.index(name)][server.time_s > last_s]
    soon = after[: max(2, round(0.2 / server.period_s))]
    return bool(len(soon) and soon[-1] == Presence.ABSENT)


def _broken_off(who: str, user: str, last_s: float, sent_s: float) -> Ending:
    """Return the end of a node, or of its recording alone where it sent packets behind it."""
    recorded = sent_s <= last_s + EARLY_S
    return Ending(who, user, last_s, "ended" if recorded else "was last recorded")


def judged_until_s(traces: SessionTraces, found: list[Ending]) -> float:
    """Return until when a session is judged [s]: a node that everybody needs ended, or the end."""
    return min([traces.duration_s, *(ending.time_s for ending in found if not ending.user)])


def shortened(traces: SessionTraces, scenario: Scenario | None) -> str:
    """Return in words by how much a session or its record is shorter than its scenario, if so."""
    cut = next((str(each["what"]) for each in traces.events if each.get("kind") == CUT), "")
    if scenario is None or traces.simulated:
        return cut
    if (end_s := session_end_s(traces, scenario)) > scenario.duration_s - EARLY_S:
        return ""
    length = f"{end_s:.1f} of {scenario.duration_s:g} s"
    return f"{cut}: {length} are on record" if cut else f"the session ended after {length}"
