# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parts of a session: its stages, and its traces up to an instant.

A stage is an interval in which no parameter changed, with its scenario. Of a simulated session
the scenario names the changes (``changes``), of a live one the recorded parameter events do. The
server takes a change over with the step after it.
"""

from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np

from pmwvc_core.errors import ScenarioError
from pmwvc_core.numeric import Flags
from pmwvc_core.scenario.names import Change, changed, read_changes
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import PacketTraces, ServerTraces, SessionTraces, UserTraces

Table = TypeVar("Table", PacketTraces, ServerTraces, UserTraces)
OF_BLOCKS = ("block_time_s", "state", "block_number", "epoch", "changes", "orientation")


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
    have (a preset's of a link, other programs' parameters), or that change nothing, are left out.
    """
    present = replace(scenario, changes="") if scenario.changes else scenario
    found = [Stage(-np.inf, present)]
    for change in changes_of(traces, scenario):
        try:
            present = changed(present, change)
        except ScenarioError:
            continue
        if change.time_s < traces.duration_s and present != found[-1].scenario:
            found.append(Stage(change.time_s, present, change))
    return found


def disturbances(traces: SessionTraces) -> list[tuple[str, str, float]]:
    """Return to which nodes a scenario asked something to be done, what, and when it was [s]."""
    asked = [each for each in traces.events if each["kind"] == "disturbance"]
    return [(e["who"], e["what"].rpartition(": ")[2], float(e["time_s"])) for e in asked]


def until(traces: SessionTraces, end_s: float) -> SessionTraces:
    """Return the motion, forces and packets before ``end_s``, without users of whom nothing is
    left; the same object where that is everything.
    """
    if end_s >= traces.duration_s:
        return traces
    late = traces.metadata.get("server_lateness_s")
    server, metadata = traces.server, dict(traces.metadata)
    if server is not None:
        kept = server.time_s < end_s
        if late is not None and len(late) == len(kept):
            metadata["server_lateness_s"] = late[kept]
        server = with_rows(server, kept) if kept.any() else None
    return replace(
        traces,
        duration_s=end_s,
        users=[user_until(user, end_s) for user in traces.users if user.block_time_s[0] <= end_s],
        server=server,
        packets={t: with_rows(each, each.time_s < end_s) for t, each in traces.packets.items()},
        metadata=metadata,
    )


def user_until(user: UserTraces, end_s: float) -> UserTraces:
    """Return the ticks of the whole blocks that ended by then."""
    blocks = user.block_time_s <= end_s + 1e-9
    last_s = float(user.block_time_s[blocks][-1])
    found = with_rows(user, user.time_s < last_s - 0.5 * user.tick_s, blocks)
    return replace(found, reason=[user.reason[block] for block in np.flatnonzero(blocks)])


def with_rows(table: Table, kept: Flags, blocks: Flags | None = None) -> Table:
    """Return some rows of a table of arrays; of a master some ticks and some blocks."""
    of_sums = kept if blocks is None else blocks
    changed: dict[str, Any] = {}
    for each in fields(table):
        values = getattr(table, each.name)
        if each.name == "contacts":  # each names its row
            rows = values[:, 0].astype(int)
            changed[each.name] = np.c_[np.cumsum(kept)[rows] - 1, values[:, 1:]][kept[rows]]
        elif isinstance(values, np.ndarray) and len(values):
            is_of_blocks = blocks is not None and each.name in OF_BLOCKS
            changed[each.name] = values[of_sums if is_of_blocks else kept]
        elif isinstance(values, dict) and each.name != "scene":
            changed[each.name] = {name: sums[of_sums] for name, sums in values.items()}
        elif isinstance(values, list) and isinstance(next(iter(values), None), np.ndarray):
            changed[each.name] = [part[kept] for part in values]
    return replace(table, **changed)
