# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What figures say of a session: title, parameters, users, time span, holes, numbered events."""

from collections.abc import Container, Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.charts.chart import Band, Span
from pmwvc_analysis.charts.style import user_tint
from pmwvc_analysis.traces import holes
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.network.effects import active
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces
from pmwvc_core.words import count

MOVED_M, MOST_BODIES = 1e-3, 4  # a body that moved less stood still; drawn beside the object


def names(traces: SessionTraces) -> list[str]:
    """Return the users in the order of their colours: the server's, then the others."""
    found = list(traces.server.users) if traces.server else []
    return found + [user.name for user in traces.users if user.name not in found]


def tint(traces: SessionTraces, name: str) -> str:
    """Return the colour of a user; that of the object for anything else."""
    known = names(traces)
    return user_tint(known.index(name)) if name in known else "object"


def bodies(server: ServerTraces) -> tuple[str, dict[str, Array]]:
    """Return the name of the object, and where those of a scene's other bodies are that moved most
    and that nobody holds, from the devices' origin ``(step, 3)`` [m].
    """
    scene, poses = server.scene, server.poses.items() if server.scene else ()
    held = [shape["body"] for shape in scene.get("shapes", ()) if shape.get("user", -1) >= 0]
    free = {n: rows[:, :3] - scene.get("origin", 0.0) for n, rows in poses if n not in held}
    first, *others = free or ["object"]
    ways_m = {name: float(np.ptp(free[name], 0).max()) for name in others}
    most = sorted(others, key=ways_m.__getitem__, reverse=True)[:MOST_BODIES]
    return first, {name: free[name] for name in most if ways_m[name] > MOVED_M}


def span(traces: SessionTraces) -> Span:
    """Return the time from the first row of any trace to the end of the session [s]."""
    rows = [user.time_s for user in traces.users]
    rows += [traces.server.time_s] if traces.server is not None else []
    low = min((float(each[0]) for each in rows if len(each)), default=0.0)
    return low, max(traces.duration_s, low + 1e-3)


def bands(traces: SessionTraces) -> list[Band]:
    """Return the intervals that were not recorded, and those in which a loop did not run."""
    missing = holes.holes(traces)
    found = [
        Band(f"{each.owner}: not recorded", (each.start_s, each.end_s), "soft") for each in missing
    ]
    loops = [(user.name, user.time_s, user.tick_s) for user in traces.users]
    if traces.server is not None:
        loops.append((holes.SERVER, traces.server.time_s, traces.server.period_s))
    for owner, time_s, period_s in loops:
        known = [(each.start_s, each.end_s) for each in missing if each.owner == owner]
        stood = holes.pauses(time_s, period_s, known)
        found += [Band(f"{owner}: did not run", each, "alarm") for each in stood]
    return found


ALARMING = ("release", "stall", "limit", "stranger", "recording", "restart")


def numbered(events: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return events numbered, and whether each is a reason to look closer."""
    return [
        {key: str(event.get(key, "")) for key in ("who", "kind", "what")}
        | {"number": str(number), "time_s": event["time_s"]}
        | {"alarming": event.get("kind") in ALARMING}
        for number, event in enumerate(events, start=1)
    ]


def title(text: str, scenario: Scenario | None) -> str:
    """Return a figure's title: its subject and the scenario."""
    return f"{text} · {scenario.name}" if scenario else text


def conditions(scenario: Scenario, source: str, *, without: Container[str] = ()) -> str:
    """Return a line of the source of a figure's numbers and the parameters of its scenario, of the
    first user where users differ; left out are those ``without`` effect on it, or varied in it.
    """
    user, master = scenario.users[0], scenario.users[0].master
    parts = [("", source), ("", count(len(scenario.users), "user"))]
    parts.append(("", f"controller {scenario.controller}"))
    if has_waves(scenario.controller):
        filtered = f"filter {master.filter.kind.replace('_', ' ')}"
        parts += [
            ("impedance", f"b = {user.impedance:.4g} N s/m"),
            ("rate_drop", f"M = {master.rate_drop}"),
            *([("channel", f"channel {scenario.channel}")] if scenario.strict else ()),
            *([] if scenario.strict else [("filter", filtered), ("hold", f"hold {master.hold}")]),
            ("coupling", f"coupling {scenario.server.coupling.replace('_', ' ')}"),
        ]
    delays = [f"{u.link_up.delay_s * 1e3:g}/{u.link_down.delay_s * 1e3:g}" for u in scenario.users]
    jitters = dict.fromkeys(
        effect.brief(link)
        for one in scenario.users
        for link in (one.link_up, one.link_down)
        for effect in active(link)
        if effect.spreads
    )
    contact = [
        ("contact_stiffness", f"K = {user.contact.contact_stiffness:g} N/m"),
        ("contact_damping", f"B = {user.contact.contact_damping:g} N s/m"),
    ]
    parts += [
        *(contact if scenario.environment.contact_law else []),
        ("delay_s", ", ".join([f"delay {', '.join(dict.fromkeys(delays))} ms", *jitters])),
        ("seed", f"seed {scenario.seed}"),
    ]
    return " · ".join(text for name, text in parts if name not in without)
