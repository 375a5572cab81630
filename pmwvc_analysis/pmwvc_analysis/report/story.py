# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The course of a session, in one paragraph with its numbers."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.budget.result import Budget
from pmwvc_analysis.figures import recorded
from pmwvc_analysis.figures.energy_charts import grouped
from pmwvc_analysis.traces.felt import felt_words
from pmwvc_core.numeric import Flags
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces
from pmwvc_core.words import count, listed, quantity

TOGETHER_S = 0.1  # first contacts closer than that have one time
MOVED_M = 1e-3
NAMED_EVENTS = ("release", "damping", "ended", "stranger")  # the first of them is named
LEAST_RATIO = 0.02  # of the largest energy: smaller ones are not named
WORDS = ("No", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight")


def story(
    traces: SessionTraces, scenario: Scenario | None, summary: dict[str, Any],
    energies: Budget | None,
) -> str:  # fmt: skip
    """Return the paragraph; what the traces do not hold is left out."""
    server = traces.server
    touched = _contact(traces, server, scenario) if server and len(server.time_s) else ()
    moved = _energy(energies) if energies is not None else ()
    felt = (f"Felt by {user['name']}: {felt_words(user)}." for user in summary["users"][:3])
    rest = (*_offsets(summary), *_safety(traces, summary))
    return " ".join([*touched, *_forces(summary), *felt, *moved, *rest])


def _contact(
    traces: SessionTraces, server: ServerTraces, scenario: Scenario | None
) -> Iterator[str]:
    rows = recorded.until_users_end(traces)
    times, touching = server.time_s[rows], zip(server.users, server.contact, strict=True)
    first = {name: float(times[np.argmax(on[rows])]) for name, on in touching if on[rows].any()}
    name = "the object" if scenario is None else scenario.environment.noun
    if not first:
        yield f"No user touched {name}."
        return
    who = listed(list(first))
    if len(first) == len(server.users) or len(first) > 3:
        who = f"{WORDS[len(first)]} user{'' if len(first) == 1 else 's'}"
    grips = scenario is not None and all(u.contact.grips for u in scenario.users)
    verb = "gripped" if grips and name == "the cube" else "touched"
    yield f"{who} {verb} {name} {_when(list(first.values()))}{_moved(server, rows)}."


def _when(times: Sequence[float]) -> str:
    if max(times) < TOGETHER_S:
        return "from the start"
    if max(times) - min(times) < TOGETHER_S:
        return f"at {min(times):.1f} s"
    if len(times) <= 3:
        return f"at {listed([f'{each:.1f} s' for each in times])}"
    return f"between {min(times):.1f} s and {max(times):.1f} s"


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
    if not found or peak < 0.05:
        return
    sizes = [f"{force:.2f} N" for force in found]
    if len(sizes) > 3:
        sizes = [f"{min(found):.2f} to {max(found):.2f} N"]
    devices = "The device" if len(found) == 1 else "The devices"
    end = "" if len(found) == 1 else "s"
    yield f"{devices} rendered up to {peak:.2f} N; force{end} at the end: {listed(sizes)}."


def _energy(energies: Budget) -> Iterator[str]:
    given = float(sum(sums[-1] for sums in energies.hands.values()))
    groups = {name: float(sums[-1]) for name, sums in grouped(energies).items()}
    largest = sorted(groups.items(), key=lambda each: -each[1])[:3]
    least = LEAST_RATIO * max(abs(given), *(abs(value) for value in groups.values()))
    taken = [f"{quantity(value, 'J')} in {name}" for name, value in largest if value > least]
    active = ((name, -value) for name, value in groups.items() if value < -least)
    made = [f"{quantity(value, 'J')} in {name}" for name, value in active]
    if not np.isfinite(given) or not taken:
        return
    hands = f"The hand{'' if len(energies.hands) == 1 else 's'}"
    text = f"{hands} {'gave' if given >= 0.0 else 'took back'} {quantity(abs(given), 'J')}"
    made_words = f"; generated: {listed(made)}" if made else ""
    yield f"{text}; at the end, stored or dissipated: {listed(taken)}{made_words}."


def _offsets(summary: dict[str, Any]) -> Iterator[str]:
    offsets = (each for each in summary.get("outcomes", []) if each["what"] == "offset")
    yield from [each["text"] for each in offsets if each["predicted"] is not None][:3]


def _safety(traces: SessionTraces, summary: dict[str, Any]) -> Iterator[str]:
    for each in traces.events:
        if each.get("kind") in NAMED_EVENTS and each["time_s"] is not None:
            yield f"At {each['time_s']:.1f} s {each['who']}: {each['what']}."
            break
    total = sum(user["safety_events"] or 0 for user in summary["users"])
    if total:
        yield f"The safety limits acted: {count(total, 'safety event')}."
