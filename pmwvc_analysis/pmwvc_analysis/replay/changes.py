# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The changes of parameters in a live session, for its replay: each with the step of the server,
or the frame of a master, that took it over.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pmwvc_analysis.recording.parameter_events import owner_of
from pmwvc_analysis.traces.stages import Stage
from pmwvc_core.numeric import Integers
from pmwvc_core.scenario.changes import Change, changes_text
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import Steps


def with_changes(
    recorded: Scenario,
    replayed: Scenario,
    stages: Sequence[Stage],
    ran_ns: Mapping[str, Integers],
    steps: Steps | None,
) -> tuple[Scenario, list[str]]:
    """Return the scenario with the recorded changes but for what was set for the replay, and what
    is to be said of them.

    ``ran_ns`` has the instants of every user's ticks, negative where none ran.
    """
    found = [stage.change for stage in stages if stage.change is not None]
    if not found:
        return replayed, []
    before, after = recorded.flat(), replayed.flat()
    fixed = {name for name, value in after.items() if before.get(name) != value}
    loops = {name: (np.flatnonzero(each >= 0), each[each >= 0]) for name, each in ran_ns.items()}
    if steps is not None:
        loops[""] = steps.tick, steps.ran_ns
    kept = [
        Change(_ran_s(change, loops, recorded.tick_s), values)
        for change in found
        if (values := {n: v for n, v in change.values.items() if n not in fixed})
    ]
    text = changes_text(kept)
    return replace(replayed, changes=text), [f"parameters change as recorded: {text}"]


def _ran_s(change: Change, loops: Mapping[str, tuple[Integers, Integers]], tick_s: float) -> float:
    """Return when the tick or step ran that took a change over [s]."""
    owner = owner_of(change.values)
    if owner is None or owner not in loops:
        return change.time_s
    tick, ran_ns = loops[owner]
    row = int(np.searchsorted(tick, change.time_s / tick_s))
    return float(ran_ns[row] * 1e-9) if row < len(tick) else change.time_s
