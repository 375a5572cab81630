# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The course of a session in one paragraph: who touched what when, and what the hands felt."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from pmwvc_analysis.traces.felt import felt_words
from pmwvc_core.numeric import Flags
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces
from pmwvc_core.words import listed

START_S = 0.1  # contacts until then are there from the start
MOVED_M, LEAST_N = 1e-3, 0.05


def story(traces: SessionTraces, scenario: Scenario | None, summary: dict[str, Any]) -> str:
    """Return the paragraph; what the traces do not hold is left out."""
    server = traces.server
    touched = _contact(traces, server, scenario) if server and len(server.time_s) else ()
    felt = (f"Felt by {user['name']}: {felt_words(user)}." for user in summary["users"][:3])
    return " ".join([*touched, *_forces(summary), *felt])


def _contact(
    traces: SessionTraces, server: ServerTraces, scenario: Scenario | None
) -> Iterator[str]:
    rows = server.time_s < traces.duration_s  # it runs on behind its users
    times, touching = server.time_s[rows], zip(server.users, server.contact, strict=True)
    first = {name: float(times[np.argmax(on[rows])]) for name, on in touching if on[rows].any()}
    name = "the object" if scenario is None else scenario.environment.noun
    if not first:
        yield f"No user touched {name}."
        return
    when = "from the start"
    if max(first.values()) >= START_S:
        when = f"at {listed(list(dict.fromkeys(f'{at_s:.1f} s' for at_s in first.values())))}"
    grips = scenario is not None and all(u.contact.grips for u in scenario.users)
    verb = "gripped" if grips and name == "the cube" else "touched"
    yield f"{listed(list(first))} {verb} {name} {when}{_moved(server, rows)}."


def _moved(server: ServerTraces, rows: Flags) -> str:
    path = server.x_o[rows]
    away = np.linalg.norm(path - path[0], axis=-1)
    if not np.isfinite(away).all() or away.max() < MOVED_M:
        return ""
    most, last = away.max() * 1e3, away[-1] * 1e3
    if last > 0.9 * most:
        return f" and moved it {last:.0f} mm"
    return f" and moved it up to {most:.0f} mm ({last:.0f} mm at the end)"


def _forces(summary: dict[str, Any]) -> Iterator[str]:
    ends = [user["force_final_n"] for user in summary["users"]]
    known = (force for force in ends if force is not None and None not in np.atleast_1d(force))
    found = [float(np.linalg.norm(force)) for force in known]
    peak = max((user["force_peak_n"] or 0.0 for user in summary["users"]), default=0.0)
    if found and peak >= LEAST_N:
        sizes = listed([f"{force:.2f} N" for force in found])
        yield f"Forces rendered: up to {peak:.2f} N; at the end {sizes}."
