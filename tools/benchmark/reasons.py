# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Reasons why another method is better than the strict channel on a network, as far as numbers of
the same sessions tell: a difference of another number that goes the same way by 10 % or more.
"""

import math

from benchmark.columns import (
    BUZZ,
    CONTACT,
    FORCE,
    LAG_FREE,
    OF_TASK,
    POSITION,
    STEP,
    Column,
    number,
    value_of,
)
from benchmark.methods import Settings
from benchmark.study import DEFAULTS, OURS, Study

CLEAR = 0.1  # part by which the other number has to differ
SHARE, LARGE = 0.2, 0.3  # of sessions in which the other method is active; of the buzz
LAG_MS = 5.0  # difference that is one
LAG = next(column for column in OF_TASK["free"] if column.name == "lag_s")


def reasons(study: Study, network: str, task: str, column: Column, method: str) -> list[str]:
    """Return sentences for a figure in which another method is better."""
    found = [
        _failing(study, network, task),
        _active(study, network, task, method),
        _held(study, network, task, column),
        _lag(study, network, column, method),
        _soft(study, network, task, column, method),
        _impedance(study, column, method),
        _lag_alone(study, network, task, column, method),
    ]
    return [text for text in found if text]


def _failing(study: Study, network: str, task: str) -> str:
    """Say where sessions of the strict channel fail."""
    rows = study.of(OURS, task, [network])[0]
    kinds = [one.failure for one in rows if one.failure]
    if not kinds:
        return ""
    kind = max(set(kinds), key=kinds.count)
    return f"`{OURS}` fails in {len(kinds)} of {len(rows)} sessions ({kind})"


def _active(study: Study, network: str, task: str, method: str) -> str:
    """Say where the other one generates energy."""
    rows = study.of(method, task, [network])[0]
    active = [one for one in rows if one.passive is False]
    if len(active) <= SHARE * len(rows):
        return ""
    most_mj = 1e3 * max(one.deficit_j for one in active)
    sessions = f"{len(active)} of {len(rows)} sessions"
    return f"`{method}` generates energy ({sessions}, {number(most_mj)} mJ)"


def settings(study: Study, network: str, task: str, column: Column, ours: float) -> list[str]:
    """Return a figure that is better with the defaults: the search was for other networks."""
    if column not in OF_TASK[task] or not study.of(DEFAULTS, task, [network])[0]:
        return []
    default = value_of(study.of(DEFAULTS, task, [network]), column)
    sign = -1.0 if column.larger else 1.0
    if not math.isfinite(default) or sign * (ours - default) <= CLEAR * min(abs(ours), 1e300):
        return []
    return [f"{column.label} {number(default)}"]


def _held(study: Study, network: str, task: str, column: Column) -> str:
    """Say where its buzz is the staircase of waves that are held from packet to packet."""
    if column not in (BUZZ, STEP):
        return ""
    shares = [one.held_share for one in study.of(OURS, task, [network])[0]]
    share = min((each for each in shares if each is not None), default=0.0)
    if not LARGE < share < math.inf:
        return ""
    return f"{100.0 * share:.0f} % of its buzz is at the rate of packets and server steps"


def _lag(study: Study, network: str, column: Column, method: str) -> str:
    """Say where its avatar follows later."""
    if column in (BUZZ, STEP) or "free" not in study.plan.tasks:
        return ""
    ours, other = (value_of(study.of(name, "free", [network]), LAG) for name in (OURS, method))
    if not math.isfinite(ours + other) or ours - other <= max(CLEAR * abs(ours), LAG_MS):
        return ""
    return f"lag: its avatar follows after {number(ours)} ms, not {number(other)}"


def _soft(study: Study, network: str, task: str, column: Column, method: str) -> str:
    """Say where the other one presses less, and has less force to be wrong about."""
    if column not in (POSITION, FORCE, BUZZ) or CONTACT not in OF_TASK[task]:
        return ""
    ours, other = (value_of(study.of(n, task, [network]), CONTACT) for n in (OURS, method))
    if not math.isfinite(ours + other) or ours - other <= CLEAR * ours:
        return ""
    return f"`{method}` presses with {number(other)} N RMS, `{OURS}` with {number(ours)}"


def _impedance(study: Study, column: Column, method: str) -> str:
    """Compare wave impedances: the offset is F tau/(2b), mass and damping grow with b."""
    ours, other = (_value(study.chosen[name], "master.impedance") for name in (OURS, method))
    if ours is None or other is None:
        return ""
    if column.name in ("coherency_m", "stiffness_n_m") and ours < (1.0 - CLEAR) * other:
        return f"b was searched as {number(ours)}, not {number(other)} N s/m"
    if column.name in ("mass_kg", "damping_n_s_m") and ours > (1.0 + CLEAR) * other:
        return f"b was searched as {number(ours)}, not {number(other)} N s/m"
    return ""


def _value(settings: Settings, name: str) -> float | None:
    texts = dict(text.split("=", 1) for text in settings)
    return float(texts[name]) if name in texts else None


def _lag_alone(study: Study, network: str, task: str, column: Column, method: str) -> str:
    """Say where its force is as good, shifted in time."""
    if column != FORCE or LAG_FREE not in OF_TASK[task]:
        return ""
    ours, other = (value_of(study.of(n, task, [network]), LAG_FREE) for n in (OURS, method))
    if not math.isfinite(ours) or ours > (1.0 + CLEAR) * other:
        return ""
    return f"delay alone: shifted in time its force error is {number(ours)} N, not {number(other)}"
