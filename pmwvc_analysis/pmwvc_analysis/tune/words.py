# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A proposal as plain data, and as a table."""

from collections.abc import Callable
from typing import Any

from pmwvc_analysis.budget.criterion import behind_counts, bounded, passive_by_account
from pmwvc_analysis.models.linear import left_out, nonlinear
from pmwvc_analysis.tune import criteria
from pmwvc_analysis.tune.criteria import Rating
from pmwvc_analysis.tune.search import Proposal
from pmwvc_core.scenario.scenario import Scenario

COLUMNS: tuple[tuple[str, str, Callable[[Rating], float | None]], ...] = (
    ("b", "N s/m", lambda row: row.choice.impedance),
    ("in touch", "N s/m", lambda row: row.choice.contact or row.choice.impedance),
    ("lag", "ms", lambda row: row.lag_s and 1e3 * row.lag_s),
    ("rendered", "N/m", lambda row: row.k_felt),
    ("mass", "kg", lambda row: row.mass_felt),
    ("noise", "mN", lambda row: 1e3 * row.noise_n),
    ("aliasing", "-", lambda row: row.aliasing_gain),
    ("cost", "JND", lambda row: row.cost),
)


def answer(scenario: Scenario, found: Proposal) -> dict[str, Any]:
    """Return the document of ``--json``."""
    return {
        "scenario": scenario.name,
        "not_linear": [element.text for element in nonlinear(scenario)],
        "bounds": list(found.bounds),
        "best": _plain(scenario, found.best),
        "others": {label: _plain(scenario, row) for label, row in found.others.items()},
    }


def _plain(scenario: Scenario, row: Rating) -> dict[str, Any]:
    numbers = {name: value for name, value in vars(row).items() if name != "choice"}
    return {"settings": row.choice.settings(scenario), **numbers}


def sentences(scenario: Scenario, found: Proposal) -> list[str]:
    """Return the proposal for a terminal."""
    best, rows = found.best, {"proposed": found.best, **found.others}
    lines = [f"{scenario.name}: what each choice renders to the first user"]
    if left := nonlinear(scenario):
        elements = ", ".join(dict.fromkeys(element.text for element in left))
        instead = ", ".join(dict.fromkeys(element.setting for element in left))
        lines.append(f"  not linear: {elements}; stiffness and mass computed with {instead}")
    if effects := left_out(scenario):
        lines.append(f"  left out of stability: {'; '.join(effects)}")
    lines += _table(scenario, rows)
    if scenario.strict:
        lines.append(
            "  channel = strict has neither anti-aliasing filter nor hold: impedances alone are "
            "chosen"
        )
    if best.k_ideal is not None and best.mass_ideal is not None:
        lines.append(
            f"  ideal: {best.k_ideal:.4g} N/m, {best.mass_ideal:.3g} kg; cost in just-noticeable "
            "differences (JND) of stiffness and weight"
        )
    session = criteria.session_of(best.choice.applied(scenario))
    along = " along the first axis" if session.dof < scenario.dof else ""
    lines.append(
        f"  proposed: simulated for {session.duration_s:g} s{along} with the scenario's hands: "
        "stable, not limited by safety, "
        + (best.simulated_passivity or "no port released more energy than it received")
    )
    exact = criteria.velocity_step(scenario) is None
    of = f"of an encoder of {criteria.ENCODER_STEP_M * 1e6:g} um, not in the cost"
    noise = of if exact else f"{criteria.NOTICED_N * 1e3:g} mN count as one JND of the cost"
    lines.append(f"  noise: {noise}")
    settings = best.choice.settings(scenario)
    words = " ".join(f"--set {key}={value}" for key, value in settings.items())
    return [*lines, f"use it with: {words}"]


def _table(scenario: Scenario, rows: dict[str, Rating]) -> list[str]:
    """Return heads, units, and a line for each rating with what was found of it."""
    width = max(map(len, rows))
    heads, units, _ = zip(*COLUMNS, strict=True)
    lines = [
        " " * (width + 4) + "  ".join(f"{head:>8}" for head in each) for each in (heads, units)
    ]
    for label, row in rows.items():
        values = {head: value(row) for head, _, value in COLUMNS}
        cells = {head: "-" if at is None else f"{at:.3g}" for head, at in values.items()}
        passive = row.passive or (row.stable and _by_account(row.choice.applied(scenario)))
        word = "  NOT stable" if not row.stable else "" if passive else "  not proved passive"
        if row.simulated not in (None, criteria.STABLE):
            word += f"  simulated: {row.simulated}"
        if row.simulated_passivity:
            word += "  simulated: NOT passive"
        lines.append(
            f"  {label:{width}}  {'  '.join(f'{each:>8}' for each in cells.values())}{word}"
        )
    return lines


def _by_account(scenario: Scenario) -> bool:
    """Tell whether the strict channel makes every port passive, behind counts within a bound."""
    behind = [user for user in scenario.users if behind_counts(user, scenario)]
    if behind:
        return len(behind) == len(scenario.users) and all(bounded(u, scenario) for u in behind)
    return passive_by_account(scenario)
