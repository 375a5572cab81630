# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reference page of all parameters, from the same metadata the checks use. Needs no ROS."""

import dataclasses
from collections.abc import Mapping
from typing import Any

from pmwvc_core.params import Spec
from pmwvc_core.params.names import flattened, leaves

_HEAD = "| name | type | unit | default | range | description |\n|---|---|---|---|---|---|\n"
_TYPE_NAMES = {float: "number", int: "whole number", bool: "true/false", str: "text"}


def docs_table(declarations: Mapping[str, Spec], defaults: Mapping[str, Any]) -> str:
    """Return a Markdown table, one row a parameter; one that has no default is required."""
    rows = [
        "| "
        + " | ".join(
            (
                f"`{name}`",
                _TYPE_NAMES[spec.kind],
                _cell(spec.unit or "-"),
                _default_text(defaults[name]) if name in defaults else "(required)",
                _cell(spec.range_text()),
                _cell(spec.description) + ("; fixed once running" if spec.read_only else ""),
            )
        )
        + " |"
        for name, spec in declarations.items()
    ]
    return _HEAD + "\n".join(rows) + "\n"


def group_table(prefix: str, kind: type) -> str:
    """Return the table of a parameter dataclass, nested groups included, by dotted name."""
    return docs_table(leaves(prefix, kind), flattened(prefix, kind()))


def reference_page(sections: Mapping[str, type]) -> str:
    """Return a Markdown page: per parameter group a heading, its docstring and its table.

    Parameters
    ----------
    sections
        Dotted prefix and dataclass; prefixes that share a dataclass (``link.up``, ``link.down``)
        share one section, written with the first of them.
    """
    shared: dict[type, list[str]] = {}
    for prefix, kind in sections.items():
        shared.setdefault(kind, []).append(prefix)
    parts = []
    for kind, prefixes in shared.items():
        heading = ", ".join(f"`{prefix}`" for prefix in prefixes)
        text = "\n".join(line.strip() for line in (kind.__doc__ or "").strip().splitlines())
        parts.append(f"## {heading}\n\n{text}\n\n{group_table(prefixes[0], kind)}")
    return "\n".join(parts)


def _default_text(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if dataclasses.is_dataclass(value):
        raise TypeError(f"{value!r} is a group of parameters, not a value")
    return f"{value:g}" if isinstance(value, float) else _cell(str(value)) or '""'


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
