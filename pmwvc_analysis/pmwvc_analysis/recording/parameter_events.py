# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that changed during a session, from the recorded ``/parameter_events``, as events of
kind ``parameter``.

The values at the start are those of the nodes' parameter files. Changes of other programs' nodes
are not looked at. A message is one event, however many parameters it changes together.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import yaml

from pmwvc_analysis.recording.parameter_cdr import ParameterChange
from pmwvc_core.params import LinkParams, MasterParams, SafetyParams
from pmwvc_core.params.names import flat_mapping, leaves

KINDS = ("master", "server", "netem", "recorder")
MOST_EVENTS = 100
MOST_NAMES = 4  # in one event
_UNITS = {
    name: spec.unit
    for prefix, kind in (("master", MasterParams), ("safety", SafetyParams), ("link", LinkParams))
    for name, spec in leaves(prefix, kind).items()
}


def parameter_changes(
    changes: Sequence[ParameterChange], folder: Path, zero_ns: int
) -> list[dict[str, Any]]:
    """Return what changed, in the order of time.

    Parameters
    ----------
    changes
        What was recorded, in the order of time.
    folder
        The session folder, with the nodes' parameter files in ``nodes``.
    zero_ns
        Begin of the session. Before it only what differs from the files counts.
    """
    known: dict[tuple[str, str], Any] = {}
    found: list[dict[str, Any]] = []
    count = 0
    for node in {change.node for change in changes}:
        known |= {(node, name): value for name, value in _at_start(folder, node)}
    for change in changes:
        node = change.node
        if node.rpartition("/")[2] not in KINDS:
            continue
        texts = []
        for name, value in change.values.items():
            before = known.get((node, name))
            known[node, name] = value
            if value != before and (before is not None or change.at_ns >= zero_ns):
                texts.append(_text(name, before, value))
        count += bool(texts)
        if texts and count <= MOST_EVENTS:
            found.append(_event(change.at_ns, node, texts))
    if count > MOST_EVENTS:
        what = f"{count - MOST_EVENTS} more changes of parameters"
        found.append({"time_s": None, "who": "session", "kind": "parameter", "what": what})
    return found


def _event(at_ns: int, node: str, texts: Sequence[str]) -> dict[str, Any]:
    more = len(texts) - MOST_NAMES
    what = ", ".join(texts[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")
    who = " ".join(node.strip("/").split("/")[-2:])
    return {"time_ns": at_ns, "who": who, "kind": "parameter", "what": what}


def _text(name: str, before: Any, value: Any) -> str:
    words = name.split(".")
    unit = _UNITS.get(name) or _UNITS.get(f"link.{words[-1]}" if "link" in words else "", "")
    unit = f" {unit}" if unit and unit != "-" else ""
    return f"{name} set to {_plain(value)}{unit}" + (
        f" (was {_plain(before)}{unit})" if before is not None else ""
    )


def _plain(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _at_start(folder: Path, node: str) -> Iterator[tuple[str, Any]]:
    """Yield the parameters that a node was started with, by dotted name."""
    *above, kind = node.strip("/").split("/")
    file = folder / "nodes" / f"{above[-1] if kind == 'master' and above else kind}.yaml"
    try:
        values = yaml.safe_load(file.read_text("utf-8"))["/**"]["ros__parameters"]
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError):
        return
    yield from flat_mapping(values).items()
