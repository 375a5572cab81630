# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Reasons why another method is better than the strict channel on a network: another number of the
same sessions that differs by 10 % or more, in the same sense. In brackets that of the strict one.
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
Reason = tuple[str, str] | None  # kind and amount
LAG = next(column for column in OF_TASK["free"] if column.name == "lag_s")


def reasons(
    study: Study, network: str, task: str, column: Column, method: str
) -> list[tuple[str, str]]:
    """Return kind and amount for a figure in which another method is better."""
    found = [
        _failing(study, network, task),
        _active(study, network, task, method),
        _held(study, network, task, column),
        _lag(study, network, column, method),
        _soft(study, network, task, column, method),
        _impedance(study, column, method),
        _lag_alone(study, network, task, column, method),
    ]
    return [each for each in found if each]


def _failing(study: Study, network: str, task: str) -> Reason:
    """Return how many sessions of the strict channel fail."""
    rows = study.of(OURS, task, [network])[0]
    kinds = [one.failure for one in rows if one.failure]
    if not kinds:
        return None
    kind = max(set(kinds), key=kinds.count)
    return "fails", f"{len(kinds)} of {len(rows)} ({kind})"


def _active(study: Study, network: str, task: str, method: str) -> Reason:
    """Return the largest energy that the other one generates."""
    rows = study.of(method, task, [network])[0]
    active = [one for one in rows if one.passive is False]
    if len(active) <= SHARE * len(rows):
        return None
    return "energy", f"{number(1e3 * max(one.deficit_j for one in active))} mJ"


def settings(study: Study, network: str, task: str, column: Column, ours: float) -> dict[str, str]:
    """Return a figure that is better with the defaults: the search was for other networks."""
    if column not in OF_TASK[task] or not study.of(DEFAULTS, task, [network])[0]:
        return {}
    default = value_of(study.of(DEFAULTS, task, [network]), column)
    sign = -1.0 if column.larger else 1.0
    if not math.isfinite(default) or sign * (ours - default) <= CLEAR * min(abs(ours), 1e300):
        return {}
    return {"defaults": number(default)}


def _held(study: Study, network: str, task: str, column: Column) -> Reason:
    """Return the share of its buzz that is the staircase of waves held from packet to packet."""
    if column not in (BUZZ, STEP):
        return None
    shares = [one.held_share for one in study.of(OURS, task, [network])[0]]
    share = min((each for each in shares if each is not None), default=0.0)
    if not LARGE < share < math.inf:
        return None
    return "buzz at the rate of packets and server steps", f"{100.0 * share:.0f} %"


def _lag(study: Study, network: str, column: Column, method: str) -> Reason:
    """Return the lags of the avatars in free motion."""
    if column in (BUZZ, STEP) or "free" not in study.plan.tasks:
        return None
    ours, other = (value_of(study.of(name, "free", [network]), LAG) for name in (OURS, method))
    if not math.isfinite(ours + other) or ours - other <= max(CLEAR * abs(ours), LAG_MS):
        return None
    return "lag", f"{number(other)} ms ({number(ours)})"


def _soft(study: Study, network: str, task: str, column: Column, method: str) -> Reason:
    """Return contact forces where that of the other one, whose error is compared, is smaller."""
    if column not in (POSITION, FORCE, BUZZ) or CONTACT not in OF_TASK[task]:
        return None
    ours, other = (value_of(study.of(n, task, [network]), CONTACT) for n in (OURS, method))
    if not math.isfinite(ours + other) or ours - other <= CLEAR * ours:
        return None
    return "contact force", f"{number(other)} N ({number(ours)})"


def _impedance(study: Study, column: Column, method: str) -> Reason:
    """Compare wave impedances: the offset is F tau/(2b), mass and damping grow with b."""
    ours, other = (_value(study.chosen[name], "master.impedance") for name in (OURS, method))
    if ours is None or other is None:
        return None
    stiffer = column.name in ("coherency_m", "stiffness_n_m") and ours < (1.0 - CLEAR) * other
    lighter = column.name in ("mass_kg", "damping_n_s_m") and ours > (1.0 + CLEAR) * other
    return ("b", f"{number(other)} N s/m ({number(ours)})") if stiffer or lighter else None


def _value(settings: Settings, name: str) -> float | None:
    texts = dict(text.split("=", 1) for text in settings)
    return float(texts[name]) if name in texts else None


def _lag_alone(study: Study, network: str, task: str, column: Column, method: str) -> Reason:
    """Return the force errors without delay where only the delay makes the difference."""
    if column != FORCE or LAG_FREE not in OF_TASK[task]:
        return None
    ours, other = (value_of(study.of(n, task, [network]), LAG_FREE) for n in (OURS, method))
    if not math.isfinite(ours) or ours > (1.0 + CLEAR) * other:
        return None
    return "force error less lag", f"{number(other)} N ({number(ours)})"
