# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Which sessions are run in bulk, compiled: those of a kind of which there is more to do than
compiling takes. Compiled code is kept on disk, so that later processes only load it. Without Numba
every session is interpreted; the numbers are the same to rounding.
"""

import hashlib
import logging
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import Any

from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.bulk.run import can_run, prepared, run

TICK_S = 35e-6  # of a user's tick, interpreted
COMPILING_S, LOADING_S = 40.0, 2.0
LOG = logging.getLogger("pmwvc")


def loops_of(scenarios: Sequence[Scenario]) -> list[Callable[..., bool] | None]:
    """Return the compiled loop for each session that is worth it, in their order; else None."""
    none: list[Callable[..., bool] | None] = [None for _ in scenarios]
    fit = [i for i, scenario in enumerate(scenarios) if can_run(scenario)]
    if sum(_takes_s(scenarios[i]) for i in fit) < LOADING_S or find_spec("numba") is None:
        return none
    kinds: dict[str, list[int]] = {}
    for i in fit:
        kinds.setdefault(_types(prepared(scenarios[i])[:6]), []).append(i)
    for kind, members in kinds.items():
        if _is_worth_it(kind, [scenarios[i] for i in members]):
            for i in members:
                none[i] = _loop()
    return none


def _types(value: Any) -> str:
    """Return the types in nested tuples: sessions with the same share their compiled loop."""
    if isinstance(value, tuple):
        return f"{type(value).__name__}({','.join(map(_types, value))})"
    return type(value).__name__


def _takes_s(scenario: Scenario) -> float:
    """Return about how long a session takes interpreted [s]."""
    return scenario.duration_s / scenario.tick_s * len(scenario.users) * TICK_S


def _loop() -> Callable[..., bool]:
    from pmwvc_core.compiled import compiled  # Numba takes its time to load
    from pmwvc_core.simulation.bulk.loop import session

    return compiled(session, kept=True)  # type: ignore[no-any-return]


def _is_worth_it(kind: str, members: Sequence[Scenario]) -> bool:
    from pmwvc_core.compiled import kept_in

    takes_s = sum(map(_takes_s, members))
    if takes_s <= LOADING_S:
        return False
    try:
        mark = kept_in() / hashlib.sha256(kind.encode()).hexdigest()[:16]
    except (OSError, RuntimeError) as error:  # no home, or one that cannot be written
        LOG.warning("sessions are not compiled: %s", error)
        return False
    if mark.exists() or takes_s <= COMPILING_S:
        return mark.exists()
    LOG.warning("compiling the laws of this kind of session: half a minute, once")
    run(members[0], _loop())
    mark.touch()
    return True
