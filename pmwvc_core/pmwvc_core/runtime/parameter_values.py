# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameter dataclasses as flat values by dotted name, the way ROS holds them, and back; and which
node is given which of a scenario's. ROS has no "not given" for a number: an optional one is a
double whose 0.0 stands for ``None`` (its range never holds zero). Needs no ROS.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import Spec
from pmwvc_core.params.names import assembled, flattened, joined, leaves, nested
from pmwvc_core.scenario.scenario import Scenario, User, prefixed

P = TypeVar("P")


class Share(NamedTuple):
    """What a node is given of a group of a scenario: all, or ``only`` some of its own."""

    prefix: str
    attribute: str  # of a user or of the scenario
    kind: type
    only: tuple[str, ...] = ()


def _shares(owner: type, *whole: str, **only: tuple[str, ...]) -> tuple[Share, ...]:
    return tuple(
        Share(prefix, attribute, kind, only.get(attribute, ()))
        for prefix, (attribute, kind) in prefixed(owner).items()
        if attribute in whole or attribute in only
    )


# The table: what each node is given of a user, and of what all users share.
USER_AT_MASTER = _shares(
    User, "master", "baseline", "own", "given_device", "given_operator", "given_safety", "contact"
)
SHARED_AT_MASTER = _shares(Scenario, "task", server=("period_s", "object_size_m", "lever_m"))
USER_AT_SERVER = _shares(
    User,
    *("contact", "baseline", "own"),
    master=("impedance", "impedance_matrix", "contact_impedance", "rate_drop", "tick_s"),
)
SHARED_AT_SERVER = _shares(Scenario, "server", "task", "own")
USER_AT_NETEM = _shares(User, "link_up", "link_down")
TOP_AT_ENDS = ("controller", "channel", "dof")  # of the scenario, at master and server


def given(shares: Sequence[Share], owner: Any, start: str = "") -> dict[str, Any]:
    """Return what a node is given below ``start``: dataclasses, and single values by name."""
    found: dict[str, Any] = {}
    for prefix, attribute, _, only in shares:
        value, where = getattr(owner, attribute), joined(start, prefix)
        found |= {joined(where, n): getattr(value, n) for n in only} if only else {where: value}
    return found


def taken_back(
    shares: Sequence[Share], values: Mapping[str, Any], start: str = ""
) -> dict[str, Any]:
    """Return a scenario's values by name from those that a node was given and holds."""
    return {
        name: from_ros(spec, values[joined(start, name)])
        for share in shares
        if not share.only
        for name, spec in leaves(share.prefix, share.kind).items()
        if joined(start, name) in values
    }


def values_of(prefix: str, owner: Any) -> dict[str, Any]:
    """Return the values of a parameter dataclass by dotted name, as ROS holds them."""
    known = leaves(prefix, type(owner))
    return {name: to_ros(known[name], value) for name, value in flattened(prefix, owner).items()}


def built(prefix: str, kind: type[P], given: Mapping[str, Any]) -> P:
    """Build a parameter dataclass from ROS values; ParameterError with every wrong name."""
    known = {name: spec for name, spec in leaves(prefix, kind).items() if name in given}
    wanted = {name: from_ros(spec, given[name]) for name, spec in known.items()}
    problems = [
        f"{name} = {problem}"
        for name, value in wanted.items()
        if (problem := known[name].problem(value))
    ]
    if problems:
        raise ParameterError("; ".join(problems))
    return assembled(prefix, kind, wanted)


def to_ros_yaml(parameters: Mapping[str, Any], *, node: str = "/**") -> dict[str, Any]:
    """Return the content of a ROS parameter file for a node, from parameter dataclasses and plain
    values by dotted name, without ``None`` and empty lists, which such a file cannot hold.
    """
    found: dict[str, Any] = {}
    for name, value in parameters.items():
        found |= values_of(name, value) if dataclasses.is_dataclass(value) else {name: value}
    kept = {name: value for name, value in found.items() if value is not None and value != []}
    return {node: {"ros__parameters": nested(kept)}}


def to_ros(spec: Spec, value: Any) -> Any:
    """Return a value of a dataclass as ROS holds it."""
    if value is None:
        return 0.0 if spec.optional and spec.kind is float else None
    return spec.kind(value)


def from_ros(spec: Spec, value: Any) -> Any:
    """Return a value as the dataclass wants it; a wrong type stays as it is, to be refused."""
    value = spec.converted(value)
    return None if spec.optional and value == 0.0 else value
