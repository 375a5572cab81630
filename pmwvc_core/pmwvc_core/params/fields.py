# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The declaration of a parameter: default, unit, range, description, and the check that uses them.

The YAML reader, the command line, the ROS declarations and the reference page all derive from this
metadata.
"""

import dataclasses
import functools
import math
import numbers
import operator
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from pmwvc_core.errors import ParameterError
from pmwvc_core.plugins import installed

_BOUNDS = {
    ">=": ("low", operator.ge), ">": ("above", operator.gt), "<=": ("high", operator.le),
    "<": ("below", operator.lt),
}  # fmt: skip
_WORDS = {"null": None, "true": True, "false": False}
_KINDS = {float: "a number", int: "a whole number", str: "a string"}


@dataclass(frozen=True)
class Spec:
    """The declaration of one parameter: ``kind`` of a value (``float``, ``int``, ``bool``,
    ``str``), ``optional``: or ``None``; exclusive bounds ``above``/``below``, inclusive
    ``low``/``high``; what is allowed, by ``choices`` and ``plugins``; ``read_only``: fixed when a
    node starts.
    """

    kind: type
    unit: str = "-"
    low: float | None = None
    high: float | None = None
    above: float | None = None
    below: float | None = None
    choices: tuple[Any, ...] = ()
    optional: bool = False
    read_only: bool = False
    description: str = ""
    plugins: Callable[[], Collection[str]] = tuple
    default: Any = None

    def range_text(self) -> str:
        """Return the allowed values in words: ``> 0 N s/m``, ``1..64``, ``one of a, b``."""
        if self.choices:
            return "one of " + ", ".join(dict.fromkeys(map(str, (*self.choices, *self.plugins()))))
        if self.kind is bool:
            return "true or false"
        limits = {sign: getattr(self, side) for sign, (side, _) in _BOUNDS.items()}
        text = " and ".join(f"{sign} {at:g}" for sign, at in limits.items() if at is not None)
        if self.low is not None and self.high is not None:
            text = f"{self.low:g}..{self.high:g}"
        unit = f" {self.unit}" if self.unit not in ("", "-") else ""
        return (text or _KINDS[self.kind]) + unit + (" or null" if self.optional else "")

    def converted(self, value: Any) -> Any:
        """Return a value in the declared type where that loses nothing; else as it is."""
        if self.kind is str:  # nothing behind a name is an empty text, the number of a column one
            return "" if value is None else str(value) if type(value) is int else value
        if isinstance(value, str):
            try:  # YAML 1.1 reads 1e-3 (no dot) as a text
                value = _WORDS[value] if value in _WORDS else float(value)
            except ValueError:
                return value
        if self.kind is float and type(value) is int:
            return float(value)
        whole = self.kind is int and isinstance(value, float) and value.is_integer()
        return int(value) if whole else value

    def problem(self, value: Any) -> str | None:
        """Return what is wrong with a value, or None."""
        if value is None and self.optional:
            return None
        if self.kind is str or self.kind is bool:
            right = isinstance(value, self.kind)
        else:
            number = isinstance(value, numbers.Real) and not isinstance(value, bool)
            right = number and math.isfinite(value) and self.kind(value) == value
            limits = ((getattr(self, side), within) for side, within in _BOUNDS.values())
            right = right and all(at is None or within(value, at) for at, within in limits)
        if self.choices:
            right = right and (value in self.choices or value in self.plugins())
        given = "null" if value is None else repr(value)
        whole = "a whole number, " * (self.kind is int and isinstance(value, float))
        return None if right else f"{given}: must be {whole}{self.range_text()}"


_NUMBER = r"-?\d+(?:\.\d+)?(?:e-?\d+)?"
_BOUND = re.compile(
    rf"(?:(?P<low>{_NUMBER})\.\.(?P<high>{_NUMBER})|(?P<side>[<>]=?) (?P<limit>{_NUMBER}))"
    r"(?: and | |$)"
)


def parameter(
    default: float | int | bool | str | None, allowed: str | tuple[Any, ...], description: str, *,
    group: str = "", read_only: bool = False,
) -> Any:  # fmt: skip
    """Declare a dataclass field that is a parameter; the default ``None`` makes it optional.
    ``allowed`` is range and unit as messages show them (``0..1 s``, ``> 0 and <= 20 N``, ``N``,
    ``-``), or all values allowed, besides plug-ins of a ``group``.
    """
    kind = float if default is None else type(default)
    spec = Spec(
        kind, optional=default is None, read_only=read_only, description=description,
        plugins=partial(installed, group) if group else tuple, default=default,
        **(_read(allowed, kind) if isinstance(allowed, str) else {"choices": allowed}),
    )  # fmt: skip
    return dataclasses.field(default=default, metadata={"spec": spec})


fixed = partial(parameter, read_only=True)  # a parameter that is fixed when a node starts


def _read(allowed: str, kind: type) -> dict[str, Any]:
    """Return the bounds and the unit that a text names."""
    found: dict[str, Any] = {}
    while bound := _BOUND.match(allowed):
        if bound["low"]:
            found |= {"low": kind(float(bound["low"])), "high": kind(float(bound["high"]))}
        else:
            found[_BOUNDS[bound["side"]][0]] = kind(float(bound["limit"]))
        allowed = allowed[bound.end() :]
    if re.search(r"[<>=]|\.\.", allowed):
        raise ValueError(f"{allowed!r}: must be a range such as '0..1' or '> 0 and <= 20', a unit")
    return found | {"unit": allowed or "-"}


def specs(kind: type) -> Mapping[str, Spec]:
    """Return the parameters of a dataclass by field name, nested groups left out."""
    return _declared(kind, "spec")


def groups(kind: type) -> Mapping[str, type]:
    """Return the nested parameter groups of a dataclass by field name."""
    return _declared(kind, "group")


@functools.cache
def _declared(kind: type, key: str) -> Mapping[str, Any]:
    return {f.name: f.metadata[key] for f in dataclasses.fields(kind) if key in f.metadata}


def group(kind: type) -> Any:
    """Declare a dataclass field that is a nested group of parameters."""
    return dataclasses.field(default_factory=kind, metadata={"group": kind})


def disordered(owner: Any, *pairs: tuple[str, str]) -> list[str]:
    """Return for which pairs of parameters the first is not below the second."""
    return [
        f"{low} = {getattr(owner, low)}: must be < {high} = {getattr(owner, high)}"
        for low, high in pairs
        if getattr(owner, low) >= getattr(owner, high)
    ]


def has(name: str, *values: str) -> Any:
    """Declare a property of a dataclass: whether a parameter of it has one of these values."""
    return property(lambda owner: getattr(owner, name) in values)


def lacks(name: str, *values: str) -> Any:
    """Declare a property of a dataclass: whether a parameter of it has none of these values."""
    return property(lambda owner: getattr(owner, name) not in values)


class Validated:
    """Base of parameters: checked when built, each, then together; else ParameterError."""

    def __post_init__(self) -> None:
        problems = [
            f"{name} = {problem}"
            for name, spec in specs(type(self)).items()
            if (problem := spec.problem(getattr(self, name)))
        ]
        if problems := problems or self.conflicts():
            raise ParameterError("; ".join(problems))

    def conflicts(self) -> list[str]:
        """Return what is wrong between fields that are each right (none unless overridden)."""
        return []
