# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The stages of a session: intervals in which no parameter changed, each with its scenario.

Of a simulated session the scenario names the changes (``changes``), of a live one the recorded
parameter events do. The server takes a change over with the step after it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pmwvc_core.errors import ScenarioError
from pmwvc_core.numeric import Flags
from pmwvc_core.scenario.changes import Change, changed, read_changes
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces


@dataclass(frozen=True)
class Stage:
    """Parameters that held from ``start_s`` on [s], and what was set then (None: the start)."""

    start_s: float
    scenario: Scenario
    change: Change | None = None


def changes_of(traces: SessionTraces, scenario: Scenario) -> list[Change]:
    """Return the changes of parameters in a session, in the order of time."""
    if traces.live:
        return [Change(time_s, values) for time_s, values in traces.settings]
    return read_changes(scenario.changes)


def stages(traces: SessionTraces, scenario: Scenario) -> list[Stage]:
    """Return the stages of a session, the first one from its start. Changes that no scenario can
    have (a preset's of a link, other programs' parameters) are left out.
    """
    present = replace(scenario, changes="") if scenario.changes else scenario
    found = [Stage(-np.inf, present)]
    for change in changes_of(traces, scenario):
        try:
            present = changed(present, change)
        except ScenarioError:
            continue
        if change.time_s < traces.duration_s:
            found.append(Stage(change.time_s, present, change))
    return found


def rows_of(found: Sequence[Stage], time_s: Iterable[float]) -> list[Flags]:
    """Return the rows of each stage among rows at these times [s]."""
    starts = [stage.start_s - 1e-9 for stage in found]
    index = np.searchsorted(starts, np.asarray(time_s), side="right") - 1
    return [index == number for number in range(len(found))]


def text_of(found: Sequence[Stage]) -> str:
    """Return what changed and when, in words; empty where nothing did."""
    changes = [stage.change for stage in found if stage.change is not None]
    shown = [f"{change.words()} at {change.time_s:.2f} s" for change in changes[:2]]
    more = f" and {len(changes) - 2} more changes" if len(changes) > 2 else ""
    return ", ".join(shown) + more
