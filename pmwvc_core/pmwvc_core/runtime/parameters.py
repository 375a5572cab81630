# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""ROS parameters from parameter dataclasses, the only source of default, type, unit, range and
description. Whole numbers given for doubles are accepted, from files and while running.
"""

import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

from rcl_interfaces import msg
from rclpy.node import Node
from rclpy.parameter import Parameter

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import Spec, specs
from pmwvc_core.params.names import joined, leaves
from pmwvc_core.runtime.parameter_values import (
    TOP_AT_ENDS,
    Share,
    built,
    from_ros,
    to_ros,
    values_of,
)
from pmwvc_core.scenario.scenario import Scenario

P = TypeVar("P")
Type = Parameter.Type
_TYPES = {float: Type.DOUBLE, int: Type.INTEGER, bool: Type.BOOL, str: Type.STRING}
_LARGEST, _LARGEST_INT = sys.float_info.max, 2**63 - 1
_NAME = re.compile("[A-Za-z][A-Za-z0-9_]*")


def declare(
    node: Node, prefix: str, kind: type[P], *, defaults: P | None = None, only: Sequence[str] = (),
    fixed: bool = True,
) -> P:  # fmt: skip
    """Declare a parameter dataclass, or ``only`` some of its own parameters, fixed at the start by
    default; ParameterError naming every wrong value that the node was given.
    """
    specs = leaves(prefix, kind)
    names = [joined(prefix, name) for name in only] or specs
    present = values_of(prefix, kind() if defaults is None else defaults)
    value = built(prefix, kind, {name: _given(node, name, present[name]) for name in names})
    accepted = values_of(prefix, value)
    for name in names:
        _describe(node, name, specs[name], accepted[name], fixed=fixed)
    return value


def declare_value(node: Node, name: str, spec: Spec, default: Any) -> Any:
    """Declare one parameter that belongs to no dataclass, fixed at the start of the node."""
    value = from_ros(spec, _given(node, name, to_ros(spec, default)))
    if problem := spec.problem(value):
        raise ParameterError(f"{name} = {problem}")
    _describe(node, name, spec, value, fixed=True)
    return value


def declare_top(node: Node) -> dict[str, Any]:
    """Declare what master and server have to be told alike; return the values by name."""
    known = specs(Scenario)
    defaults = {name: known[name].default for name in TOP_AT_ENDS} | {"controller": "pmwvc"}
    return {name: declare_value(node, name, known[name], defaults[name]) for name in TOP_AT_ENDS}


def declare_names(node: Node, name: str, default: Sequence[str], description: str) -> list[str]:
    """Declare a list of names for topics, fixed at the start; ParameterError if it is none."""
    value = _given(node, name, list(default))
    if not isinstance(value, list) or not all(isinstance(entry, str) for entry in value):
        raise ParameterError(f"{name} = {value!r}: must be a list of strings, like ['a','b']")
    for entry in value:
        if not _NAME.fullmatch(entry):
            raise ParameterError(
                f"{name}: {entry!r} must be letters, digits and _, beginning with a letter"
            )
        if value.count(entry) > 1:
            raise ParameterError(f"{name}: {entry!r} is there twice")
    kind = Type.STRING_ARRAY
    descriptor = msg.ParameterDescriptor(type=kind.value, description=description, read_only=True)
    node.set_descriptor(name, descriptor, Parameter(name, kind, value).get_parameter_value())
    return value


class _Group(NamedTuple):
    """A dataclass whose values may change, and the checks of a change."""

    prefix: str
    kind: type
    specs: Mapping[str, Spec]
    listener: Callable[[Any], None]
    check: Callable[[Any], None]
    check_change: Callable[[Any, Any], None]


class ParameterBinding:
    """Parameters of one node that may change while it runs. A change is checked by building the
    complete new dataclass, and refused as a whole. An accepted one reaches the group's listener as
    a new object, in the thread that serves parameters; then ``settled`` is called, once for what
    was set together. One per node.
    """

    def __init__(self, node: Node, *, settled: Callable[[], None] = lambda: None) -> None:
        self._node, self._settled = node, settled
        self._groups: list[_Group] = []
        node.add_pre_set_parameters_callback(self._convert)
        node.add_on_set_parameters_callback(self._validate)
        node.add_post_set_parameters_callback(self._hand_over)

    def declare(
        self,
        prefix: str,
        kind: type[P],
        listener: Callable[[P], None],
        *,
        defaults: P | None = None,
        check: Callable[[P], None] = lambda _: None,
        check_change: Callable[[P, P], None] = lambda _, __: None,
    ) -> P:
        """Declare a parameter dataclass; return its values at the start. ``check`` raises
        ParameterError for what it cannot know, then and at each change; ``check_change``, given
        the present object and the new one, for a step that is not allowed while running.
        """
        value = declare(self._node, prefix, kind, defaults=defaults, fixed=False)
        check(value)
        specs = leaves(prefix, kind)
        self._groups.append(_Group(prefix, kind, specs, listener, check, check_change))
        return value

    def declare_shares(
        self,
        shares: Sequence[Share],
        start: str = "",
        *,
        defaults: Mapping[str, Any] | None = None,
        **changing: Mapping[str, Any],
    ) -> dict[str, Any]:
        """Declare the node's shares of a user or scenario below ``start``; return values by
        attribute. ``changing`` are arguments of :meth:`declare` of those that may change.
        """
        found = {}
        for prefix, attribute, kind, only in shares:
            where, default = joined(start, prefix), (defaults or {}).get(attribute)
            if attribute in changing:
                options = changing[attribute]
                found[attribute] = self.declare(where, kind, defaults=default, **options)
            else:
                found[attribute] = declare(self._node, where, kind, defaults=default, only=only)
        return found

    def _convert(self, parameters: list[Parameter]) -> list[Parameter]:
        """Turn whole numbers given for doubles into doubles."""
        floats = {n for g in self._groups for n, spec in g.specs.items() if spec.kind is float}
        return [
            Parameter(p.name, Type.DOUBLE, float(p.value))
            if p.type_ == Type.INTEGER and p.name in floats
            else p
            for p in parameters
        ]

    def _validate(self, parameters: list[Parameter]) -> msg.SetParametersResult:
        try:
            for group, present, value in self._rebuilt(parameters):
                group.check(value)
                group.check_change(present, value)
        except ParameterError as error:
            return msg.SetParametersResult(successful=False, reason=str(error))
        return msg.SetParametersResult(successful=True)

    def _hand_over(self, parameters: list[Parameter]) -> None:
        for group, _, value in self._rebuilt(parameters):
            group.listener(value)
        self._settled()

    def _rebuilt(self, parameters: list[Parameter]) -> Iterator[tuple[_Group, Any, Any]]:
        """Yield every group a change touches: as it is, and with the new values."""
        touched = [g for p in parameters for g in self._groups if p.name in g.specs]
        for group in {id(group): group for group in touched}.values():
            of, new = (group.prefix, group.kind), {p.name: p.value for p in parameters}
            present = {name: self._node.get_parameter(name).value for name in group.specs}
            changed = {name: new.get(name, value) for name, value in present.items()}
            yield group, built(*of, present), built(*of, changed)


def _given(node: Node, name: str, default: Any) -> Any:
    """Return what the node was given for a parameter, of whatever type, else the default."""
    if not node.has_parameter(name):
        node.declare_parameter(name, default, msg.ParameterDescriptor(dynamic_typing=True))
    return node.get_parameter(name).value


def _describe(node: Node, name: str, spec: Spec, value: Any, *, fixed: bool) -> None:
    """Give a parameter type, closed range and description; ``additional_constraints`` is exact."""
    parameter = Parameter(name, _TYPES[spec.kind], to_ros(spec, value))
    unit = f" [{spec.unit}]" if spec.unit and spec.unit != "-" else ""
    absent = " (0: not given)" if spec.optional else ""
    descriptor = msg.ParameterDescriptor(
        type=_TYPES[spec.kind].value,
        description=f"{spec.description}{unit}{absent}",
        additional_constraints=spec.range_text().replace(" or null", " or 0"),
        read_only=fixed or spec.read_only,
    )
    low = spec.above if spec.low is None else spec.low
    high = spec.below if spec.high is None else spec.high
    bounded = low is not None or high is not None
    if spec.optional:
        low = min(low or 0.0, 0.0)  # zero stands for "not given"
    largest = _LARGEST_INT if spec.kind is int else _LARGEST
    low, high = -largest if low is None else low, largest if high is None else high
    if bounded and spec.kind is int:
        descriptor.integer_range = [msg.IntegerRange(from_value=int(low), to_value=int(high))]
    elif bounded:
        span = msg.FloatingPointRange(from_value=float(low), to_value=float(high))
        descriptor.floating_point_range = [span]
    node.set_descriptor(name, descriptor, parameter.get_parameter_value())
