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
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces

KEPT = 48  # sessions: some 5 MB each


@functools.lru_cache(maxsize=KEPT)
def simulated(scenario: Scenario) -> SessionTraces:
    """Return the traces of a scenario; whoever changes an array takes a copy of them first."""
    traces = simulate_one(scenario)
    for array in _arrays(traces):
        array.setflags(write=False)
    return traces


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


def late_s(batch, user):
    """Return the time from port to port at the end of a stepped session, T1 + T2 of a user, with
    its playouts and without the ramps [s].
    """
    ends = batch.server.s.guests[user].arrivals, batch.users[user].loop.s.arrivals
    end_ns = batch.ticks * batch.tick_ns
    sent_s = ((end_ns - each.counting.sent_ns) * 1e-9 for each in ends)
    return sum(sent_s) + sum(each.playout.pace.store_s for each in ends)


def least_j(energy):
    """Return the least balance of both directions and of the port of a user's hand beside what was
    declared to be stored at the start; zero or more where nothing was made [J].
    """
    return min(each.minimum_j + each.declared_j for each in energy.parts.values())
