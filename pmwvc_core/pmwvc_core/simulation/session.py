# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in virtual time: the frame protocol of the live nodes, as fast as the machine can.

With the schedule of a scenario (:data:`pmwvc_core.frame.schedule.AT_ONCE`) frame start, server
step and answer are one instant: without delay a packet arrives when it was sent.
:mod:`pmwvc_core.simulation.conditions` can give other phases.

Deterministic: the same scenario gives the same bits. Batched: scenarios of equal structure are
stepped together on arrays ``(runs, dof)``; a single run with one axis is stepped on floats, as the
live loop is.
"""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.batch import SessionBatch
from pmwvc_core.simulation.conditions import FROM_SCENARIO, Conditions
from pmwvc_core.simulation.stacking import batches
from pmwvc_core.traces import SessionTraces

R = TypeVar("R")
SMALLEST_BATCH = 6  # numbers are quicker than arrays of fewer
LARGEST_BATCH = 512  # bounds the memory of the traces: 330 MB per user and ten seconds


def simulate_one(scenario: Scenario, conditions: Conditions = FROM_SCENARIO) -> SessionTraces:
    """Simulate one scenario."""
    return simulate([scenario], conditions=conditions)[0]


def simulate(
    scenarios: Sequence[Scenario],
    *,
    keep: Callable[[SessionTraces, Scenario], R] | None = None,
    progress: Callable[[float], None] | None = None,
    conditions: Conditions = FROM_SCENARIO,
) -> list[R] | list[SessionTraces]:
    """Simulate scenarios, those of equal structure side by side where that is quicker.

    Parameters
    ----------
    scenarios
        Run in batches; results come in the same order.
    keep
        Reduces the traces of each run, with its scenario (to its verdict, for example); all traces
        by default.
    progress
        Called with the ratio done, 0..1.
    conditions
        Conditions that the scenarios do not name; the same for all.
    """
    results: list[Any] = [None] * len(scenarios)
    done = 0
    for members in batches(scenarios, smallest=SMALLEST_BATCH, largest=LARGEST_BATCH):
        batch = SessionBatch([scenarios[i] for i in members], conditions)

        def report(ratio: float, *, before: int = done, size: int = len(members)) -> None:
            if progress is not None:
                progress((before + ratio * size) / len(scenarios))

        batch.run(report)
        for run, position in enumerate(members):
            traces = batch.traces(run)
            results[position] = traces if keep is None else keep(traces, scenarios[position])
        done += len(members)
        del batch  # before the next one takes as much memory
    return results
