# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The declaration of a parameter: default, unit, range, description, and the check that uses them.

The YAML reader, the command line, the ROS declarations and the reference page all derive from this
metadata. A number may be an array with a last axis of length 1: one value per run of a batch.
"""

import dataclasses
import functools
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from pmwvc_core.errors import ParameterError
from pmwvc_core.plugins import installed


@dataclass(frozen=True)
class Spec:
    """The declaration of one parameter.

    ``kind`` is the Python type of a value (``float``, ``int``, ``bool``, ``str``); ``optional``
    allows ``None``. ``above``/``below`` are exclusive bounds, ``low``/``high`` inclusive ones.
    ``choices`` lists allowed names, ``plugins`` returns those that other packages add.
    ``read_only`` parameters are fixed when a node starts. Above ``usual`` a value in seconds is
    allowed, but meant in milliseconds more often.
    """

    kind: type
    unit: str = ""
    low: float | None = None
    high: float | None = None
    above: float | None = None
    below: float | None = None
    choices: tuple[str, ...] = ()
    optional: bool = False
    read_only: bool = False
    description: str = ""
    plugins: Callable[[], tuple[str, ...]] | None = None
    usual: float | None = None

    def doubt(self, value: Any) -> str:
        """Return what is unusual about a value that is allowed; "" where nothing is."""
        if self.usual is None or value <= self.usual:
            return ""
        return f"{value:g} s: longer than on any network on Earth; {value:g} ms is {value / 1e3:g}"

    def range_text(self) -> str:
        """Return the allowed values in words: ``> 0 N s/m``, ``1..64``, ``one of a, b``."""
        unit = f" {self.unit}" if self.unit and self.unit != "-" else ""
        if self.choices:
            return "one of " + ", ".join([*self.choices, *self._added()])
        if self.kind is bool:
            return "true or false"
        bounds = []
        if self.low is not None and self.high is not None:
            bounds.append(f"{self.low:g}..{self.high:g}")
        else:
            bounds += [f">= {self.low:g}"] if self.low is not None else []
            bounds += [f"> {self.above:g}"] if self.above is not None else []
            bounds += [f"<= {self.high:g}"] if self.high is not None else []
        bounds += [f"< {self.below:g}"] if self.below is not None else []
        text = (
            " and ".join(bounds)
            or {float: "a number", int: "a whole number", str: "a string"}[self.kind]
        )
        return text + unit + (" or null" if self.optional else "")

    def _added(self) -> tuple[str, ...]:
        found = self.plugins() if self.plugins is not None else ()
        return tuple(name for name in found if name not in self.choices)

    def _allowed(self, name: Any) -> bool:
        return not self.choices or name in self.choices or name in self._added()

    def _number_text(self) -> str:
        """Return the allowed values of a number, and that it is one."""
        kind, allowed = "a whole number" if self.kind is int else "a number", self.range_text()
        return allowed if allowed.startswith(kind) else f"{kind}, {allowed}"

    def problem(self, value: Any) -> str | None:
        """Return what is wrong with a value, or None."""
        if value is None:
            return None if self.optional else f"null: must be {self.range_text()}"
        if self.kind is str or self.kind is bool:
            right = isinstance(value, self.kind) and self._allowed(value)
            return None if right else f"{value!r}: must be {self.range_text()}"
        numbers = np.asarray(value)
        if (
            isinstance(value, (bool, list, tuple))
            or numbers.dtype.kind not in "iuf"
            or numbers.size == 0
        ):
            return f"{value!r}: must be {self._number_text()}"
        if not np.isfinite(numbers).all():
            return f"{value!r}: must be finite and {self.range_text()}"
        if self.kind is int and not (numbers == np.floor(numbers)).all():
            return f"{value!r}: must be {self._number_text()}"
        inside = (
            (self.low is None or (numbers >= self.low).all())
            and (self.high is None or (numbers <= self.high).all())
            and (self.above is None or (numbers > self.above).all())
            and (self.below is None or (numbers < self.below).all())
        )
        percent = (self.low, self.high) == (0.0, 1.0) and np.size(value) == 1 and 1 < value <= 100
        way_out = f"; {value:g} % is {value / 100:g}" if percent and self.kind is float else ""
        return None if inside else f"{value!r}: must be {self.range_text()}{way_out}"


_NUMBER = r"-?\d+(?:\.\d+)?(?:e-?\d+)?"
_BOUND = re.compile(
    rf"(?:(?P<low>{_NUMBER})\.\.(?P<high>{_NUMBER})|(?P<side>[<>]=?) (?P<limit>{_NUMBER}))"
    r"(?: and | |$)"
)
_SIDES = {">=": "low", ">": "above", "<=": "high", "<": "below"}


NO_DEFAULT: Any = dataclasses.MISSING  # in place of a default: a value has to be given


def parameter(
    default: float | int | bool | str | None,
    allowed: str | tuple[str, ...],
    description: str,
    *,
    kind: type | None = None,
    group: str = "",
    read_only: bool = False,
    usual: float | None = None,
) -> Any:
    """Declare a dataclass field that is a parameter.

    Parameters
    ----------
    allowed
        Range and unit, as messages show them: ``0..1 s``, ``> 0 and <= 20 N``, ``>= 1``; ``-``
        without either. Or the names allowed.
    kind
        Type of a value; needed only where the default is ``NO_DEFAULT``. ``None`` is that of an
        optional number.
    group
        Group of entry points whose plug-ins are allowed besides the names.
    """
    kind = kind or (float if default is None else type(default))
    more = _read(allowed, kind) if isinstance(allowed, str) else {"unit": "-", "choices": allowed}
    plugins = partial(installed, group) if group else None
    spec = Spec(
        kind,
        optional=default is None,
        read_only=read_only,
        description=description,
        plugins=plugins,
        usual=usual,
        **more,
    )
    return dataclasses.field(default=default, metadata={"spec": spec})


fixed = partial(parameter, read_only=True)  # a parameter that is fixed when a node starts


def _read(allowed: str, kind: type) -> dict[str, Any]:
    """Return the bounds and the unit that a text names."""
    found: dict[str, Any] = {}
    while bound := _BOUND.match(allowed):
        if bound["low"]:
            found |= {"low": kind(float(bound["low"])), "high": kind(float(bound["high"]))}
        else:
            found[_SIDES[bound["side"]]] = kind(float(bound["limit"]))
        allowed = allowed[bound.end() :]
    if re.search(r"[<>=]|\.\.", allowed):
        raise ValueError(f"{allowed!r}: must be a range such as '0..1' or '> 0 and <= 20', a unit")
    return found | {"unit": allowed or "-"}


def specs(owner: Any) -> Mapping[str, Spec]:
    """Return the parameters of a dataclass by field name, nested groups left out."""
    return _declared(owner if isinstance(owner, type) else type(owner), "spec")


def groups(owner: Any) -> Mapping[str, type]:
    """Return the nested parameter groups of a dataclass by field name."""
    return _declared(owner if isinstance(owner, type) else type(owner), "group")


@functools.cache
def _declared(kind: type, key: str) -> Mapping[str, Any]:
    """Return the metadata of the fields of a dataclass that have a key, by field name."""
    return {f.name: f.metadata[key] for f in dataclasses.fields(kind) if key in f.metadata}


def group(kind: type) -> Any:
    """Declare a dataclass field that is a nested group of parameters."""
    return dataclasses.field(default_factory=kind, metadata={"group": kind})


class Is:
    """An attribute of a dataclass: whether a parameter of it has one of these values."""

    def __init__(self, name: str, *values: str) -> None:
        self.name, self.values = name, values

    def __get__(self, owner: Any, _: type) -> bool:
        return getattr(owner, self.name) in self.values


class IsNot(Is):
    """An attribute of a dataclass: whether a parameter of it has none of these values."""

    def __get__(self, owner: Any, kind: type) -> bool:
        return not super().__get__(owner, kind)


class Validated:
    """Base of every parameter dataclass: checks all fields once, when built; ParameterError naming
    the field, its value and the allowed range.
    """

    def __post_init__(self) -> None:
        """Check every declared field, then what holds between fields."""
        problems = [
            f"{name} = {problem}"
            for name, spec in specs(self).items()
            if (problem := spec.problem(getattr(self, name)))
        ]
        if problems := problems or self.conflicts():
            raise ParameterError("; ".join(problems))

    def conflicts(self) -> list[str]:
        """Return what is wrong between fields that are each right (none unless overridden)."""
        return []


def whole_ratio(period_s: float, tick_s: float) -> int | None:
    """Return how many ticks make a period, or None when they do not divide (within 1e-9)."""
    ratio = period_s / tick_s
    count = round(ratio)
    return count if count >= 1 and math.isclose(ratio, count, rel_tol=1e-9) else None
