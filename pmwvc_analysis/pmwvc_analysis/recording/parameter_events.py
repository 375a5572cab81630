# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that changed during a session, from the recorded ``/parameter_events``, as events of
kind ``parameter``.

Changes of other programs' nodes are not looked at. A message is one event, however many parameters
it sets together.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.recording import schemas
from pmwvc_core.errors import ScenarioError
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.scenario.names import Change, spec_of, split_user
from pmwvc_core.traces import ServerTraces, UserTraces

KINDS = ("master", "server", "netem", "recorder")
EARLY_S = 0.0005  # before the tick or step that took a change over: it counts from there on
SAME_S = 1e-9  # an event and the look that took it over may be of one instant
LATE_S = 0.5  # of such a tick or step, from the time of the event
NEVER = np.zeros(0), np.zeros(0)
Settings = list[tuple[float, dict[str, Any]]]


class ParameterChange(NamedTuple):
    """Values that a node changed together; a value that is a list is "a list"."""

    at_ns: int
    node: str
    values: dict[str, Any]


def taken_over(
    settings: Settings, users: Sequence[UserTraces], server: ServerTraces | None
) -> Settings:
    """Return the settings at the times at which they took effect [s], as far as that is known:
    just before the step of the server, or the tick of a master, that took them over. A node
    publishes its event before.
    """
    taken: dict[str | None, tuple[Array, Array]] = {
        user.name: _with_changes(user, user.block_rows) for user in users
    }
    if server is not None:
        taken[""] = _with_changes(server, np.arange(len(server.time_s)))
    found: Settings = []
    for time_s, values in settings:
        times, ran = taken.get(owner_of(values), NEVER)
        later = times[(ran > time_s - SAME_S) & (ran < time_s + LATE_S)]
        found.append((float(later[0]) - EARLY_S if len(later) else time_s, values))
    return sorted(found, key=lambda each: each[0])


def owner_of(names: Iterable[str]) -> str | None:
    """Return the user whose master takes parameters over, "" for the server; None: any other."""
    owners: set[str | None] = set()
    for number, path in map(split_user, names):
        group = path.split(".")[0]
        own = f"user{number}" if number and group in ("master", "safety") else None
        owners.add("" if group == "server" else own)
    return owners.pop() if len(owners) == 1 else None


def _with_changes(trace: UserTraces | ServerTraces, rows: Integers) -> tuple[Array, Array]:
    """Return the times of the ticks or steps that took changes over, due and as they ran [s]."""
    rows = rows[np.diff(trace.changes, prepend=0) > 0]
    due_s = trace.time_s[rows]
    return due_s, due_s + trace.looked_ns[rows] * 1e-9


def parameter_change(data: bytes) -> ParameterChange | None:
    """Return a message's changed parameters, or None where it is no such message."""
    store = schemas.typestore()
    definition = store.get_msgdef(schemas.PARAMETER_EVENT)
    decode = definition.deserialize_cdr_le if data[1:2] == b"\1" else definition.deserialize_cdr_be
    try:  # not the store's own way: it refuses the bytes that Fast DDS leaves behind a message
        event: Any = decode(memoryview(data)[4:], 0, definition.cls, store)[0]
    except Exception:  # rosbags raises many kinds
        return None
    values = {each.name: _plain(each.value) for each in event.changed_parameters}
    return ParameterChange(nanoseconds(event.stamp), event.node, values)


def _plain(value: Any) -> Any:
    plain = (value.bool_value, value.integer_value, value.double_value, value.string_value)
    return dict(enumerate(plain, start=1)).get(value.type, "a list")


def parameter_changes(
    changes: Sequence[ParameterChange], zero_ns: int
) -> tuple[list[dict[str, Any]], Settings]:
    """Return what was set in the order of time: as events, and as times [s] and values by their
    names in a scenario.
    """
    found: list[dict[str, Any]] = []
    settings: Settings = []
    for at_ns, node, values in changes:
        if node.rpartition("/")[2] not in KINDS or not values:
            continue
        set_to: dict[str, Any] = {}
        for name, value in values.items():
            set_to |= _in_scenario(node, name, value)
        if set_to:
            settings.append(((at_ns - zero_ns) * 1e-9, set_to))
        what = f"set {Change(at_ns * 1e-9, values).words()}"
        who = " ".join(node.strip("/").split("/")[-2:])
        found.append({"time_ns": at_ns, "who": who, "kind": "parameter", "what": what})
    return found, settings


def _in_scenario(node: str, name: str, value: Any) -> dict[str, Any]:
    """Return a node's setting by its name in a scenario; nothing where it has none there."""
    *above, kind = node.strip("/").split("/")
    path = f"{above[-1]}.{name}" if kind == "master" and above else name
    try:
        spec = spec_of(path)
    except ScenarioError:
        return {}
    return {path: None if spec.optional and value == 0 else value}
