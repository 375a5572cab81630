#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
# ruff: noqa: E501 (lines of Markdown)
"""Write ``docs/parameters.md`` from the dataclasses of the parameters: ``make docs``."""

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pmwvc_core.network.effects import amounts
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.params import LinkParams, Spec, ports, specs
from pmwvc_core.params.fields import groups
from pmwvc_core.params.names import joined, leaves
from pmwvc_core.scenario.scenario import Scenario, User, prefixed

ROOT = Path(__file__).resolve().parents[1]
_HEAD = "| name | default | range | description |\n|---|---|---|---|\n"

PARAMETERS_HEAD = """# Parameters

Scenario files, `--set`, ROS parameters and reports use the same dotted names:

```
./pmwvc simulate carry_16ms --set server.contact_stiffness=2000           # every user
./pmwvc simulate carry_16ms --set user2.server.contact_stiffness=2000     # one user: any name of the second part
./pmwvc simulate carry_16ms --set link.delay_s=0.02                       # directly below link: both directions
```

The heading of a table begins the names in it: `period_s` below `server` is `server.period_s`. A range has the unit of its
parameter, or the words to choose from. Parameters with a star cannot change once a node runs. `make docs` writes this page.

## What all users share
"""
EACH_USER = """
## What each user has for itself

`side` (`user1.side`): -1 or 1, the side of the object a user is on; -1 pushes towards +x. Users alternate by default.
"""
MASTERS_HEAD = """
## Impedances by name: `master.preset`

`master: {preset: light}` in a scenario file or `--set user2.master.preset=firm` sets these, on the strict channel
([comparison](tuning.md#two-impedances)). Other settings beside it take precedence.

"""
NETWORKS_HEAD = """
## Networks by name: `link.preset`

A preset sets a whole link: `link: {preset: lte}` in a scenario file, `--set user2.link.down.preset=geo`, or `preset` of
the emulator node, at its start. Other settings beside it take precedence. "Estimate" marks values without a measurement.

| name | conditions | basis |
|---|---|---|
"""


def parameters_page() -> str:
    """Return the text of the parameter page."""
    shared = {prefix: kind for prefix, (_, kind) in prefixed(Scenario).items()}
    each = {prefix: kind for prefix, (_, kind) in prefixed(User).items()}
    return _joined(
        PARAMETERS_HEAD,
        docs_table(specs(Scenario)),
        reference_page(shared),
        EACH_USER,
        reference_page(each),
        MASTERS_HEAD + _masters(),
        NETWORKS_HEAD
        + "\n".join(
            f"| `{name}` | {_both(_link(preset.up), _link(preset.down))} | {preset.basis} |"
            for name, preset in PRESETS.items()
        ),
    )


def _masters() -> str:
    """Return a table, one column a preset."""
    names = dict.fromkeys(each for preset in ports.MASTERS.values() for each in preset)
    rows = [
        [f"`{each}`", *(json.dumps(p[each]) for p in ports.MASTERS.values())] for each in names
    ]
    head = [["", *(f"`{name}`" for name in ports.MASTERS)], ["---"] * (1 + len(ports.MASTERS))]
    return "\n".join(f"| {' | '.join(row)} |" for row in head + rows)


def _both(up: str, down: str) -> str:
    return up if up == down else f"up {up}; down {down}"


def _link(params: LinkParams) -> str:
    """Return delay, jitter, loss and the rest of a link in words."""
    return ", ".join([f"{params.delay_s * 1e3:g} ms", *amounts(params).values()])


def _joined(*parts: str) -> str:
    return "\n".join(part.strip("\n") + "\n" for part in parts)


def docs_table(declarations: Mapping[str, Spec]) -> str:
    """Return a Markdown table, one row a parameter; one that has no default is required."""
    rows = [
        "| "
        + " | ".join(
            (
                f"`{name}`" + ("\\*" if spec.read_only else ""),
                _default_text(spec.default),
                _cell(spec.range_text().removeprefix("one of "))
                + (", whole" if spec.kind is int else ""),
                _cell(spec.description),
            )
        )
        + " |"
        for name, spec in declarations.items()
    ]
    return _HEAD + "\n".join(rows) + "\n"


def group_table(prefix: str, kind: type) -> str:
    """Return the table of a parameter dataclass, nested groups included.

    Names begin behind the prefix, which is the heading of the table.
    """
    named = leaves(prefix, kind)
    return docs_table({name.removeprefix(f"{prefix}."): spec for name, spec in named.items()})


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
        if prefix:  # those without belong to whatever plug-ins are installed
            shared.setdefault(kind, []).append(prefix)
    parts, first = [], dict[type, str]()
    for kind, prefixes in shared.items():
        heading = ", ".join(f"`{prefix}`" for prefix in prefixes)
        text = "\n".join(line.strip() for line in (kind.__doc__ or "").strip().splitlines())
        table = group_table(prefixes[0], kind)
        for name, nested in groups(kind).items():
            known = first.setdefault(nested, joined(prefixes[0], name))
            if known != joined(prefixes[0], name):
                rows = [row for row in table.splitlines() if not row.startswith(f"| `{name}.")]
                table = "\n".join([*rows, f"| `{name}.*` | | | as `{known}.*` |", ""])
        parts.append(f"## {heading}\n\n{text}\n\n{table}")
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


if __name__ == "__main__":
    (ROOT / "docs" / "parameters.md").write_text(parameters_page(), "utf-8")
