# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""ROS parameters from parameter dataclasses: type, unit, range and description from each field's
``Spec``.

Whole numbers given for doubles are accepted, from files and while running. How dataclasses become
flat values by dotted name is in :mod:`pmwvc_core.runtime.parameter_values`. No default, range or
unit belongs here: the dataclasses are the only source.
"""

import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import Spec
from pmwvc_core.params.names import hint, leaves
from pmwvc_core.runtime.parameter_values import built, from_ros, to_ros, values_of

P = TypeVar("P")
_TYPES = {
    float: Parameter.Type.DOUBLE,
    int: Parameter.Type.INTEGER,
    bool: Parameter.Type.BOOL,
    str: Parameter.Type.STRING,
}
_LARGEST_INT = 2**63 - 1
_NAME = re.compile("[A-Za-z][A-Za-z0-9_]*")
_OWN_OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides.")


def declare(node: Node, prefix: str, kind: type[P], *, defaults: P | None = None) -> P:
    """Declare a parameter dataclass whose values are fixed at the start of the node.

    Raises
    ------
    ParameterError
        If a value given to the node is wrong; names every wrong one.
    """
    return _declared(node, prefix, kind, defaults, fixed=True)


def declare_value(node: Node, name: str, spec: Spec, default: Any) -> Any:
    """Declare one parameter that belongs to no dataclass, fixed at the start of the node."""
    value = from_ros(spec, _given(node, name, to_ros(spec, default)))
    problem = spec.problem(value)
    if problem:
        raise ParameterError(f"{name} = {problem}")
    _describe(node, name, spec, value, fixed=True)
    return value


def declare_names(node: Node, name: str, default: Sequence[str], description: str) -> list[str]:
    """Declare a list of names that become part of topics, fixed at the start of the node.

    Raises
    ------
    ParameterError
        If it is no list of texts, or a name in it cannot be used or is there twice.
    """
    value = _given(node, name, list(default))
    if not isinstance(value, list) or not all(isinstance(entry, str) for entry in value):
        raise ParameterError(f"{name} = {value!r}: must be a list of texts, like ['a','b']")
    for entry in value:
        if not _NAME.fullmatch(entry):
            raise ParameterError(
                f"{name}: {entry!r} must be letters, digits and _, beginning with a letter"
            )
        if value.count(entry) > 1:
            raise ParameterError(f"{name}: {entry!r} is there twice")
    descriptor = ParameterDescriptor(
        type=Parameter.Type.STRING_ARRAY.value, description=description, read_only=True
    )
    parameter = Parameter(name, Parameter.Type.STRING_ARRAY, value)
    node.set_descriptor(name, descriptor, parameter.get_parameter_value())
    return value


def refuse_undeclared(node: Node) -> None:
    """Refuse parameters that were given to the node and that it does not declare.

    For a node made with ``automatically_declare_parameters_from_overrides``, once all is declared.

    Raises
    ------
    ParameterError
        Naming each with the nearest right name.
    """
    known: list[str] = []
    unknown: list[str] = []
    for name in node.get_parameters_by_prefix(""):
        if not name.startswith(_OWN_OF_ROS):
            (known if node.describe_parameter(name).description else unknown).append(name)
    if unknown:
        texts = [f"{name}: there is no such parameter{hint(name, known)}" for name in unknown]
        raise ParameterError("; ".join(texts))


@dataclass(frozen=True, eq=False)
class _Group:
    """A dataclass whose values may change, and the checks of a change."""

    prefix: str
    kind: type
    listener: Callable[[Any], None]
    check: Callable[[Any], None]
    check_change: Callable[[Any, Any], None]


def set_together(node: Node, values: Mapping[str, Any]) -> None:
    """Set parameters of a node by itself, all or none; a refusal is logged."""
    wanted = [Parameter(name, value=value) for name, value in values.items()]
    if wanted and not (result := node.set_parameters_atomically(wanted)).successful:
        node.get_logger().warning(result.reason)


class ParameterBinding:
    """Parameters of one node that may change while it runs.

    A change is checked by building the complete new dataclass from the old values and the new
    ones, and refused as a whole with the dataclass's own message. An accepted one reaches the
    group's listener as a complete new object, in the thread that serves parameters: the listener
    only hands it over, the owner applies it at a frame boundary.

    Make one per node; ROS asks it about all sets of parameters of that node.

    Parameters
    ----------
    settled
        Called behind the listeners of a set of parameters: what they hand over belongs together.
    """

    def __init__(self, node: Node, *, settled: Callable[[], None] = lambda: None) -> None:
        self._node = node
        self._settled = settled
        self._specs: dict[str, Spec] = {}
        self._owner: dict[str, _Group] = {}
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
        """Declare a parameter dataclass and return its values at the start.

        Parameters
        ----------
        prefix
            What its dotted names start with.
        kind
            The dataclass.
        listener
            Gets the complete new object after each accepted change.
        defaults
            Values where nothing is given to the node; those of the dataclass by default.
        check
            Raises ``ParameterError`` for what the dataclass cannot know, at the start and at each
            change.
        check_change
            Gets the present object and the new one; raises ``ParameterError`` for a step that is
            not allowed while running.

        Raises
        ------
        ParameterError
            If a value given to the node is wrong.
        """
        value = _declared(self._node, prefix, kind, defaults, fixed=False)
        check(value)
        group = _Group(prefix, kind, listener, check, check_change)
        for name, spec in leaves(prefix, kind).items():
            self._specs[name] = spec
            self._owner[name] = group
        return value

    def _convert(self, parameters: list[Parameter]) -> list[Parameter]:
        """Turn whole numbers given for doubles into doubles."""
        return [
            Parameter(p.name, Parameter.Type.DOUBLE, float(p.value))
            if p.type_ == Parameter.Type.INTEGER
            and p.name in self._specs
            and self._specs[p.name].kind is float
            else p
            for p in parameters
        ]

    def _validate(self, parameters: list[Parameter]) -> SetParametersResult:
        try:
            for group, present, value in self._rebuilt(parameters):
                group.check(value)
                group.check_change(present, value)
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _hand_over(self, parameters: list[Parameter]) -> None:
        for group, _, value in self._rebuilt(parameters):
            group.listener(value)
        self._settled()

    def _rebuilt(self, parameters: list[Parameter]) -> Iterator[tuple[_Group, Any, Any]]:
        """Yield every group a change touches: as it is, and with the new values."""
        new = {p.name: p.value for p in parameters if p.name in self._owner}
        for group in dict.fromkeys(self._owner[name] for name in new):
            prefix, kind = group.prefix, group.kind
            names = leaves(prefix, kind)
            present = {name: self._node.get_parameter(name).value for name in names}
            changed = {n: new[n] for n in names if n in new}
            yield group, built(prefix, kind, present), built(prefix, kind, present | changed)


def _declared(node: Node, prefix: str, kind: type[P], defaults: P | None, *, fixed: bool) -> P:
    present = values_of(prefix, kind() if defaults is None else defaults)
    given = {name: _given(node, name, value) for name, value in present.items()}
    value = built(prefix, kind, given)
    accepted = values_of(prefix, value)
    for name, spec in leaves(prefix, kind).items():
        _describe(node, name, spec, accepted[name], fixed=fixed)
    return value


def _given(node: Node, name: str, default: Any) -> Any:
    """Return what the node was given for a parameter, of whatever type, else the default."""
    if not node.has_parameter(name):
        node.declare_parameter(name, default, ParameterDescriptor(dynamic_typing=True))
    return node.get_parameter(name).value


def _describe(node: Node, name: str, spec: Spec, value: Any, *, fixed: bool) -> None:
    """Give a parameter its type, range and description; a whole number becomes a double."""
    parameter = Parameter(name, _TYPES[spec.kind], to_ros(spec, value))
    node.set_descriptor(name, _descriptor(spec, fixed=fixed), parameter.get_parameter_value())


def _descriptor(spec: Spec, *, fixed: bool) -> ParameterDescriptor:
    """Return the descriptor for tools; ranges are closed, ``additional_constraints`` is exact."""
    unit = f" [{spec.unit}]" if spec.unit and spec.unit != "-" else ""
    absent = " (0: not given)" if spec.optional else ""
    descriptor = ParameterDescriptor(
        type=_TYPES[spec.kind].value,
        description=f"{spec.description}{unit}{absent}",
        additional_constraints=spec.range_text().replace(" or null", " or 0"),
        read_only=fixed or spec.read_only,
    )
    low = spec.above if spec.low is None else spec.low
    high = spec.below if spec.high is None else spec.high
    if low is None and high is None:
        return descriptor
    if spec.optional:
        low = min(low or 0.0, 0.0)  # zero stands for "not given"
    if spec.kind is int:
        integers = IntegerRange(
            from_value=-_LARGEST_INT if low is None else int(low),
            to_value=_LARGEST_INT if high is None else int(high),
        )
        descriptor.integer_range = [integers]
    else:
        largest = sys.float_info.max
        numbers = FloatingPointRange(
            from_value=-largest if low is None else float(low),
            to_value=largest if high is None else float(high),
        )
        descriptor.floating_point_range = [numbers]
    return descriptor
