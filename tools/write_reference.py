#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
# ruff: noqa: E501 (lines of Markdown)
"""Write ``docs/parameters.md`` and ``docs/messages.md`` from their sources: ``make docs``."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pmwvc_core.network.effects import amounts
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.params import LinkParams, Spec, specs
from pmwvc_core.params.fields import NO_DEFAULT
from pmwvc_core.params.names import leaves
from pmwvc_core.scenario.scenario import Scenario, User, prefixed

ROOT = Path(__file__).resolve().parents[1]
_HEAD = "| name | type | unit | default | range | description |\n|---|---|---|---|---|---|\n"
_TYPE_NAMES = {float: "number", int: "whole number", bool: "true/false", str: "text"}

PARAMETERS_HEAD = """# Parameters

Dotted names, used alike in scenario files, `--set`, ROS parameters and reports. `user2.` in front of a name of the
second part means that user only; `link.delay_s` (directly below `link`) means both directions. This page is written
by `make docs`.

## What all users share
"""
EACH_USER = """
## What each user has for itself

`side` (`user1.side`): -1 or 1, the side of the object a user is on; -1 pushes towards +x. Users alternate by default.
"""
NETWORKS_HEAD = """
## Networks by name: `link.preset`

A preset stands for every setting of a link, in both directions: `link: {preset: lte}` in a scenario file, `--set
link.preset=lte`, `--set user2.link.down.preset=geo`. Settings given beside it win. The node netem takes the same names
as `preset`. A preset is plausible, not universal: "estimate" marks what no measurement stands behind. Jitter is independent from
packet to packet, so packets overtake each other where it exceeds their interval. `pmwvc links SCENARIO` prints the command of Linux for each link.

| name | up | down | basis |
|---|---|---|---|
"""
MESSAGES_HEAD = """# Topics and messages

One namespace per user; names inside a node are relative, so that a whole session can be put below a namespace of its
own (`/lab/user1/wave_up`, `/lab/markers`); only `/diagnostics` and `/parameter_events` are global. The second part of this page is written by `make docs` from
`pmwvc_msgs/msg`.

| topic | type | from | to | quality of service |
|---|---|---|---|---|
| `/user1/wave_up` | Wave | master | netem | best effort, keep last 10, volatile |
| `/server/user1/wave_up` | Wave | netem | server | same |
| `/server/user1/wave_down` | Wave | server | netem | same |
| `/user1/wave_down` | Wave | netem | master | same |
| each of these with `/sent` behind it | Wave | its publisher | recorder | reliable, keep last 10,000 |
| `/user1/trace` | MasterTrace | master | recorder, viewers | reliable, keep last 10,000 |
| `/server/trace` | ServerTrace | server | recorder, viewers | same |
| `/user1/reception`, `/server/reception` | Reception (2 Hz) | master, server | recorder, viewers | same |
| `/netem/links` | LinkState | netem | recorder, viewers | same |
| `/netem/fates` | PacketFate | netem | recorder | same |
| `/user1/measured_cv`, `/user1/measured_cf` | TwistStamped, WrenchStamped | master | viewers | best effort, packet rate |
| `/user1/hand/target` | geometry_msgs/PointStamped | a view, any program | master with `operator.kind: remote`, recorder | best effort, keep last 4 |
| `/user1/hand/held` | std_msgs/Bool | same | same | reliable, keep last 4 |
| `/view/restart` | std_msgs/String | view | runner (`pmwvc run --view`) | reliable; JSON of settings |
| `/markers` | MarkerArray (frame `world`, 30 Hz) | server | RViz, Foxglove | reliable |
| `/parameter_events` | rcl_interfaces/ParameterEvent | every node | recorder: changes are events of the session | reliable |
| `/diagnostics` | DiagnosticArray (1 Hz) | all | people | reliable |

Masters and server offer a deadline of three periods on waves and traces; a subscriber without one is matched all the
same. The emulator offers none: it passes on what comes.

With the device plug-in `ros_topic` a master also reads `/user1/device/measured_cp` (PoseStamped) and, where there is
one, `/user1/device/measured_cv` (TwistStamped), and writes `/user1/device/servo_cf` (WrenchStamped) every tick.

**A hand from outside.** With `operator.kind: remote` (and no `operator.file`) the simulated hand of a master follows
`hand/target`: the position [m] of the handle in the frame of the world, on as many axes as the session has (at most 3).
Publish it 60 to 125 times a second while the handle is held, also where it does not move, and nothing otherwise. The
newest one counts; its age is counted from its arrival by the master's own clock, stamps are ignored. The hand lets
go when none has come for 150 ms, with a value that is not finite, or with `held: false`; after that, targets are ignored
until `held: true`. A publisher that never sends `held` needs no `held: true`. The hand has let go after 100 ms at most; a target
after that takes hold where the handle is.

There is no TF: `tf2_msgs` is in none of the wheels that `make setup` installs. Positions of object, avatars and target
are in `/markers` (frame `world`) and in the traces.

Without the emulator the two sides are joined by remapping: start the server with
`-r /server/user1/wave_up:=/user1/wave_up -r /server/user1/wave_down:=/user1/wave_down`.

| service | type | node | what it does |
|---|---|---|---|
| `~/start` | std_srvs/Trigger | master, server, netem | begin, where `start.paused` is true |
| `~/matched` | std_srvs/Trigger | every node | returns as JSON how many other ends each of its own publishers and subscriptions has matched |
| `~/rearm` | std_srvs/Trigger | master | leave the fault state; the force starts from zero |

A node that joins a running session is best started with `start.joins:=true`: it begins once its waves and its trace
have found their other ends (after 10 s in any case), so that its first packets and the first rows of its trace arrive.
`start.listeners` says how many subscribers the trace has to find (1). A session does that with nodes that it starts again, with 2:
its recorder and the runner's monitor.

What is recorded is kept by its publisher for ten seconds at 1 kHz (80 s at 125 Hz) and sent again to a recorder that has
missed it. Packets are therefore published twice: once for the other end, which gets them at most once, and once for the
recorder. A best-effort publisher and a reliable subscriber do not connect, silently: subscribe to waves with best effort.
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
        NETWORKS_HEAD
        + "\n".join(
            f"| `{name}` | {_link(preset.up)} | {_link(preset.down)} | {preset.basis} |"
            for name, preset in PRESETS.items()
        ),
    )


def _link(params: LinkParams) -> str:
    """Return delay, jitter, loss and the rest of a link in words."""
    return ", ".join([f"{params.delay_s * 1e3:g} ms", *amounts(params).values()])


def messages_page() -> str:
    """Return the text of the page on topics and messages."""
    files = sorted((ROOT / "pmwvc_msgs" / "msg").glob("*.msg"))
    return _joined(MESSAGES_HEAD, *(_message(file) for file in files))


def _message(file: Path) -> str:
    head, rows = [], []
    for line in file.read_text("utf-8").splitlines():
        field, _, comment = line.partition("#")
        if not field.strip():
            head += [comment.strip()] if "SPDX" not in comment else []
        else:
            kind, name = field.split(maxsplit=1)
            rows.append(
                f"| `{name.strip()}` | {kind} | {comment.strip().replace('|', chr(92) + '|')} |"
            )
    text = " ".join(part for part in head if part)
    return "\n".join(
        [f"## {file.stem}", "", text, "", "| field | type | |", "|---|---|---|", *rows]
    )


def _joined(*parts: str) -> str:
    return "\n".join(part.strip("\n") + "\n" for part in parts)


def docs_table(declarations: Mapping[str, Spec]) -> str:
    """Return a Markdown table, one row a parameter; one that has no default is required."""
    rows = [
        "| "
        + " | ".join(
            (
                f"`{name}`",
                _TYPE_NAMES[spec.kind],
                _cell(spec.unit or "-"),
                "(required)" if spec.default is NO_DEFAULT else _default_text(spec.default),
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
    return docs_table(leaves(prefix, kind))


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


PAGES = {"parameters.md": parameters_page, "messages.md": messages_page}

if __name__ == "__main__":
    for name, page in PAGES.items():
        (ROOT / "docs" / name).write_text(page(), "utf-8")
