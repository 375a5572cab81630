# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameter dataclasses as flat values by dotted name, the way ROS holds them, and back. Needs no
ROS.

A field ``impedance`` of the group ``master`` becomes ``master.impedance``; nested groups become
further dotted names. ROS has no "not given" for a number: an optional one is a double whose 0.0
stands for ``None`` (its range never holds zero). Whole numbers are accepted for doubles.
"""

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import Spec, groups, specs

P = TypeVar("P")


def leaves(prefix: str, kind: type) -> Iterator[tuple[str, Spec]]:
    """Yield dotted name and declaration of every parameter of a dataclass, nested groups too."""
    start = f"{prefix}." if prefix else ""
    for name, spec in specs(kind).items():
        yield f"{start}{name}", spec
    for name, nested in groups(kind).items():
        yield from leaves(f"{start}{name}", nested)


def values_of(prefix: str, owner: Any) -> dict[str, Any]:
    """Return the values of a parameter dataclass by dotted name, as ROS holds them."""
    start = f"{prefix}." if prefix else ""
    found = {f"{start}{n}": to_ros(spec, getattr(owner, n)) for n, spec in specs(owner).items()}
    for name in groups(owner):
        found |= values_of(f"{start}{name}", getattr(owner, name))
    return found


def built(prefix: str, kind: type[P], values: Mapping[str, Any]) -> P:
    """Build a parameter dataclass from ROS values by dotted name.

    Raises
    ------
    ParameterError
        Naming every wrong parameter by its dotted name.
    """
    wanted = {name: (spec, from_ros(spec, values[name])) for name, spec in leaves(prefix, kind)}
    problems = [
        f"{name} = {problem}"
        for name, (spec, value) in wanted.items()
        if (problem := spec.problem(value))
    ]
    if problems:
        raise ParameterError("; ".join(problems))
    return _assembled(prefix, kind, {name: value for name, (_, value) in wanted.items()})


def _assembled(prefix: str, kind: type[P], values: Mapping[str, Any]) -> P:
    start = f"{prefix}." if prefix else ""
    nested: dict[str, Any] = {
        n: _assembled(f"{start}{n}", inner, values) for n, inner in groups(kind).items()
    }
    try:
        return kind(**{name: values[f"{start}{name}"] for name in specs(kind)}, **nested)
    except ParameterError as error:
        raise ParameterError(f"{start}{error}") from None


def to_ros_yaml(values: Mapping[str, Any], *, node: str = "/**") -> dict[str, Any]:
    """Return the content of a ROS parameter file.

    Parameters
    ----------
    values
        By dotted name: parameter dataclasses (written as all their parameters) and plain values.
        ``None`` and empty lists, which such a file cannot hold, are left out.
    node
        Full name of the node the file is for.
    """
    nested: dict[str, Any] = {}
    for prefix, value in values.items():
        whole = dataclasses.is_dataclass(value)
        for name, plain in (values_of(prefix, value) if whole else {prefix: value}).items():
            if plain is None or plain == []:
                continue
            *path, leaf = name.split(".")
            place = nested
            for part in path:
                place = place.setdefault(part, {})
            place[leaf] = plain
    return {node: {"ros__parameters": nested}}


def to_ros(spec: Spec, value: Any) -> Any:
    """Return a value of a dataclass as ROS holds it."""
    if value is None:
        return 0.0 if spec.optional and spec.kind is float else None
    return spec.kind(value)


def from_ros(spec: Spec, value: Any) -> Any:
    """Return a value as the dataclass wants it; a wrong type stays as it is, to be refused."""
    if spec.kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if spec.kind is str and type(value) is int:  # -p operator.columns:=1
        value = str(value)
    return None if spec.optional and value == 0.0 else value
