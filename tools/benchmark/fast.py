# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions one by one, compiled where a study has enough of a kind: 12 ms in place of 1 s for ten
seconds of two users. What is compiled is decided beforehand, so that the same study gives the same
numbers whatever has been compiled on this machine before.
"""

import functools
from collections.abc import Callable
from importlib.util import find_spec

from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.bulk import run as bulk
from pmwvc_core.simulation.bulk.loop import session
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.simulation.traces import traces_of
from pmwvc_core.traces import SessionTraces


def can_compile(scenario: Scenario) -> bool:
    """Tell whether sessions like this one can be compiled: methods from outside cannot."""
    return find_spec("numba") is not None and bulk.can_run(scenario)


def pays(sessions: int, scenario: Scenario) -> bool:
    """Tell whether so many sessions take so long interpreted that compiling them pays."""
    ticks = scenario.duration_s / scenario.tick_s * len(scenario.users)
    return sessions * ticks > bulk.COMPILING_TICKS and can_compile(scenario)


def simulated(scenario: Scenario, *, compiled: bool) -> SessionTraces:
    """Return the traces of a session."""
    if compiled:
        left = bulk.run(scenario, _loop())
        if left.whole:
            return traces_of(left)
    return simulate_one(scenario)


@functools.cache
def _loop() -> Callable[..., bool]:
    from pmwvc_core.compiled import compiled  # Numba takes its time to load

    loop: Callable[..., bool] = compiled(session, kept=True)
    return loop
