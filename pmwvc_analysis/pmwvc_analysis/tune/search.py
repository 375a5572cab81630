# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The search: filters and holds that are fit for the rate drop, and the best impedance of each. On
the strict channel, which has neither, the impedance alone.

The best impedance of a filter and a hold is found from their lag and the noise of the encoder
(:mod:`.candidates`); the few choices that are left are then rated by the exact model.

The best choice is then simulated with the scenario's own hands. One that is not stable there, or
limited by safety, gives way to the next best, and at last to a smaller impedance.
"""

import dataclasses
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pmwvc_analysis.models import stability
from pmwvc_analysis.models.linear import Element, axes_of, nonlinear
from pmwvc_analysis.tune.candidates import best_impedance, bounds_of, filters_of
from pmwvc_analysis.tune.criteria import Choice, Rating, is_stable, rated
from pmwvc_analysis.verdicts import passivity_words
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.controllers.library import record_of
from pmwvc_core.errors import PmwvcError
from pmwvc_core.params import FilterParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.wave.impedance import first_axis

STEP = 1.5  # factor between the alternatives
WIDE = 2.0  # likewise, where no choice found from the lag is stable
HOLDS = ("foh", "zoh")
STABLE, NOT_JUDGED = "stable", "stability not judged"
LEAST_S, LONGEST_S = 4.0, 12.0
USER_TICKS = 48_000  # that may be simulated: some 1 s
COUPLED = 8  # of them for a tick with axes that are coupled
Key = tuple[str, str]  # filter, hold


@dataclass(frozen=True)
class Proposal:
    """The proposed choice, and the others by name: as given, stiffer, lighter, other filters and
    holds.

    ``bounds`` are the least and largest impedance examined [N s/m], ``elements`` those of the
    scenario that no linear model covers.
    """

    best: Rating
    others: dict[str, Rating]
    bounds: tuple[float, float]
    elements: list[Element]


def propose(scenario: Scenario, *, live: bool = False) -> Proposal:
    """Return the best choice for a scenario and its neighbours.

    Raises
    ------
    PmwvcError
        If the scenario is no wave session, or nothing found is stable, in the model or simulated.
    """
    record = record_of(scenario.controller)
    if not record.waves:
        raise PmwvcError(
            f"{scenario.name}: controller = {record.name}: impedance, filter and hold "
            "belong to waves; docs/controllers.md has the tuning rules of the others"
        )
    if record.linear != record.name:
        raise PmwvcError(
            f"{scenario.name}: controller = {record.name}: has no exact model to tune it by; "
            "tune controller = pmwvc, and check the result with 'pmwvc simulate'"
        )
    bounds, filters = bounds_of(scenario), filters_of(scenario)
    user = scenario.users[0]
    holds = (user.master.hold,) if scenario.strict else HOLDS
    rows: dict[Key, Rating] = {}
    for name, hold in itertools.product(filters, holds):
        choice = best_impedance(scenario, filters[name], hold, bounds, live=live)
        rows[name, hold] = rated(scenario, choice, live=live)
    if all(row.cost is None for row in rows.values()):
        rows |= elsewhere(scenario, filters, list(rows), bounds, live=live)
    usable = {key: row for key, row in rows.items() if row.cost is not None}
    if not usable:
        raise PmwvcError(_refusal(scenario, list(rows.values()), bounds))
    passive = {key: row for key, row in usable.items() if row.passive} or usable
    for key, row in _tries(scenario, passive, bounds, live=live):
        best_key, best = key, judged(scenario, row)
        if best.simulated in (STABLE, None):
            break
    else:
        raise PmwvcError(
            f"{scenario.name}: nothing is proposed: every choice that the model calls stable is "
            f"'{best.simulated}' when simulated; 'pmwvc simulate' shows why. A finer encoder, a "
            "softer environment or a gentler hand may help"
        )
    given = Choice(first_axis(user.impedance), user.master.filter, user.master.hold, True)
    others = {"as given": judged(scenario, rated(scenario, given, live=live))}
    for label, factor in (("stiffer", STEP), ("lighter", 1.0 / STEP)):
        impedance = float(np.clip(best.choice.impedance * factor, *bounds))
        if impedance != best.choice.impedance:
            choice = dataclasses.replace(best.choice, impedance=impedance)
            others[label] = rated(scenario, choice, live=live)
    for (name, hold), row in rows.items():
        if (name == best_key[0]) != (hold == best_key[1]):  # one of both differs
            others[f"{name}, {hold}"] = row
    return Proposal(best, others, bounds, nonlinear(scenario))


def _tries(
    scenario: Scenario, rows: dict[Key, Rating], bounds: tuple[float, float], *, live: bool
) -> Iterator[tuple[Key, Rating]]:
    """Yield the choices from the best on, then the best one with less and less impedance."""
    order = sorted(rows, key=lambda key: (round(rows[key].cost or 0.0, 3), key))
    yield from ((key, rows[key]) for key in order)
    best = rows[order[0]]
    choice = best.choice
    while choice.impedance > bounds[0]:
        choice = dataclasses.replace(choice, impedance=max(choice.impedance / STEP, bounds[0]))
        row = rated(scenario, choice, live=live)
        if row.stable and row.passive >= best.passive:
            yield order[0], row


def elsewhere(
    scenario: Scenario,
    filters: dict[str, FilterParams],
    keys: Sequence[Key],
    bounds: tuple[float, float],
    *,
    live: bool,
) -> dict[Key, Rating]:
    """Return the best stable choice of each filter and hold among impedances a factor ``WIDE``
    apart, where none of those found from the lag is stable.
    """
    count = 1 + math.ceil(math.log(bounds[1] / bounds[0]) / math.log(WIDE))
    found: dict[Key, Rating] = {}
    for key, b in itertools.product(keys, np.geomspace(*bounds, count).tolist()):
        choice = Choice(b, filters[key[0]], key[1])
        if is_stable(scenario, choice, live=live):
            row = rated(scenario, choice, live=live)
            if row.cost is not None and (key not in found or row.cost < (found[key].cost or 0.0)):
                found[key] = row
    return found


def _refusal(scenario: Scenario, rows: Sequence[Rating], bounds: tuple[float, float]) -> str:
    """Return that nothing is stable, and what may help, in words."""
    helps = (
        "make the environment softer or server.period_s shorter, give device.damping, or take "
        "server.coupling = implicit where it is another"
    )
    if all(stability.stable(row.spectral_radius) for row in rows):
        helps = (
            "they are stable in contact, but nothing damps a device that touches nothing; "
            "give it device.damping (a hand damps it as well, which the model leaves out), or "
            "make the environment softer"
        )
    return (
        f"{scenario.name}: no impedance from {bounds[0]:.3g} to {bounds[1]:.3g} N s/m (looked at "
        f"within a factor of {WIDE:g}) is stable with any filter; {helps}"
    )


def session_of(scenario: Scenario) -> Scenario | None:
    """Return the session that a choice is judged by; None where that is too much work.

    Axes that no matrix couples are equal: the one along which the hands press stands for them.
    """
    if axes_of(scenario) == 1:
        task = dataclasses.replace(scenario.task, sideways_m=0.0)
        scenario = dataclasses.replace(scenario, dof=1, task=task)
    ticks = USER_TICKS / len(scenario.users) / (COUPLED if scenario.dof > 1 else 1)
    longest_s = min(LONGEST_S, ticks * scenario.tick_s)
    if longest_s < min(LEAST_S, scenario.duration_s):
        return None
    return dataclasses.replace(scenario, duration_s=min(scenario.duration_s, longest_s))


def judged(scenario: Scenario, row: Rating) -> Rating:
    """Return the rating of a choice with the verdicts of its session in virtual time."""
    session = session_of(row.choice.applied(scenario))
    if session is None:
        return row
    traces = simulate_one(session)
    found = verdict(traces, session)
    ports = passivity(traces, session, None)
    owners = dict.fromkeys(each.owner for each in ports.findings if each.passive is False)
    words = [f"{owner}: {passivity_words.verdict(ports, owner)}" for owner in owners]
    stable = STABLE if found.stable else found.instability or NOT_JUDGED
    not_passive = "; ".join(words) or None
    return dataclasses.replace(row, simulated=stable, simulated_passivity=not_passive)
