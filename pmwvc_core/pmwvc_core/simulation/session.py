# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in virtual time: the frame protocol of the live nodes, as fast as the machine can.

With the schedule of a scenario (:data:`pmwvc_core.frame.schedule.AT_ONCE`) frame start, server
step and answer are one instant: without delay a packet arrives when it was sent.
:mod:`pmwvc_core.simulation.conditions` can give other phases.

Deterministic: the same scenario gives the same bits; compiled, for many sessions
(:mod:`.bulk.choice`), the same numbers to rounding.
"""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.bulk.choice import loops_of
from pmwvc_core.simulation.bulk.run import run
from pmwvc_core.simulation.bulk.traces import traces_of
from pmwvc_core.simulation.conditions import FROM_SCENARIO, Conditions
from pmwvc_core.simulation.stepped import SteppedSession
from pmwvc_core.traces import SessionTraces

R = TypeVar("R")


def simulate_one(scenario: Scenario, conditions: Conditions = FROM_SCENARIO) -> SessionTraces:
    """Simulate one scenario."""
    return _stepped(scenario, conditions, lambda ratio: None)


def simulate(
    scenarios: Sequence[Scenario],
    *,
    keep: Callable[[SessionTraces, Scenario], R] | None = None,
    progress: Callable[[float], None] | None = None,
    conditions: Conditions = FROM_SCENARIO,
) -> list[R] | list[SessionTraces]:
    """Simulate scenarios, many of a kind compiled.

    Parameters
    ----------
    scenarios
        Results come in the same order.
    keep
        Reduces the traces of each run, with its scenario (to its verdict, for example); all traces
        by default.
    progress
        Called with the ratio done, 0..1.
    conditions
        Conditions that the scenarios do not name; the same for all.
    """
    results: list[Any] = []
    alone = len(scenarios) == 1 or conditions is not FROM_SCENARIO
    loops = [None] * len(scenarios) if alone else loops_of(scenarios)
    for done, (scenario, loop) in enumerate(zip(scenarios, loops, strict=True)):

        def report(ratio: float, *, before: int = done) -> None:
            if progress is not None:
                progress((before + ratio) / len(scenarios))

        traces = _in_bulk(scenario, loop) if loop is not None else None
        if traces is None:
            traces = _stepped(scenario, conditions, report)
        report(1.0)
        results.append(traces if keep is None else keep(traces, scenario))
    return results


def _stepped(
    scenario: Scenario, conditions: Conditions, progress: Callable[[float], None]
) -> SessionTraces:
    session = SteppedSession(scenario, conditions)
    session.run(progress)
    return session.traces()


def _in_bulk(scenario: Scenario, loop: Callable[..., bool]) -> SessionTraces | None:
    """Return the traces of a session; None where a wave did not go by the plan of the network."""
    left = run(scenario, loop)
    return traces_of(left) if left.whole else None
