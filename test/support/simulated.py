# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session cache: each scenario is simulated, and judged, once for all tests of a worker.

::

    traces = simulated(scenario)         # read-only; a ``copy.deepcopy`` may be changed
    result = judged(scenario)
"""

import copy
import dataclasses
import functools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.batch import SessionBatch
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.simulation.stacking import batches
from pmwvc_core.traces import SessionTraces

KEPT = 48  # sessions: some 5 MB each


@functools.lru_cache(maxsize=KEPT)
def simulated(scenario: Scenario) -> SessionTraces:
    """Return the traces of a scenario; whoever changes an array takes a copy of them first."""
    traces = simulate_one(scenario)
    for array in _arrays(traces):
        array.setflags(write=False)
    return traces


def side_by_side(scenarios: Sequence[Scenario]) -> list[SessionTraces]:
    """Return the sessions of scenarios, those of equal structure as one batch however few."""
    found: dict[int, SessionTraces] = {}
    for members in batches(scenarios, smallest=1, largest=len(scenarios)):
        batch = SessionBatch([scenarios[i] for i in members])
        batch.run(lambda ratio: None)
        found |= {i: batch.traces(run) for run, i in enumerate(members)}
    return [found[i] for i in range(len(scenarios))]


def judged(scenario: Scenario) -> dict[str, Any]:
    """Return the summary of a scenario's session."""
    return copy.deepcopy(_judged(scenario))


@functools.lru_cache(maxsize=KEPT)
def _judged(scenario: Scenario) -> dict[str, Any]:
    return summary(simulated(scenario), scenario)


def _arrays(value: Any) -> Iterator[np.ndarray]:
    """Yield every array of nested dataclasses, mappings and sequences."""
    if isinstance(value, np.ndarray):
        yield value
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from _arrays(getattr(value, field.name))
    elif isinstance(value, Mapping):
        for part in value.values():
            yield from _arrays(part)
    elif isinstance(value, list | tuple):
        for part in value:
            yield from _arrays(part)
