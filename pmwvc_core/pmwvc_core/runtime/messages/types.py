# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The message classes, live ones and those of rosbags, and what both have in common.

Both are built by keywords; they differ only in what a sequence and a byte are.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from pmwvc_core.numeric import Value
from pmwvc_core.runtime.messages.fields import Stamp

NS_PER_S = 1_000_000_000
_NAMES = {
    **{"Time": "builtin_interfaces", "Header": "std_msgs"},
    **dict.fromkeys(("DiagnosticArray", "DiagnosticStatus", "KeyValue"), "diagnostic_msgs"),
    **dict.fromkeys(("Wave", "MasterTrace", "ServerTrace"), "pmwvc_msgs"),
    **dict.fromkeys(("LinkState", "PacketFate", "Reception"), "pmwvc_msgs"),
}


@dataclass(frozen=True, slots=True)
class MessageTypes:
    """The message classes by name, and what their sequences are made of.

    ``sequence(values, kind)`` makes a sequence of numbers (typecodes or numpy types), ``flags``
    one of booleans, ``octet`` a single byte.
    """

    by_name: Mapping[str, Any]
    sequence: Callable[[Any, Any], Any]
    flags: Callable[[Sequence[bool]], Any]
    octet: Callable[[int], Any]

    def __getattr__(self, name: str) -> Any:
        """Return a message class: ``types.Wave(...)``."""
        try:
            return self.by_name[name]
        except KeyError:
            raise AttributeError(name) from None


def live_types() -> MessageTypes:
    """Return the message classes of rclpy."""
    by_name = {n: getattr(import_module(f"{package}.msg"), n) for n, package in _NAMES.items()}
    return MessageTypes(
        by_name,
        sequence=lambda values, _: values,
        flags=lambda values: [bool(value) for value in values],
        octet=lambda value: bytes((value,)),
    )


def types_from(classes: Mapping[str, Any]) -> MessageTypes:
    """Return the message classes of ``typestore.types`` of rosbags that knows ``pmwvc_msgs``."""
    return MessageTypes(
        {name: classes[f"{package}/msg/{name}"] for name, package in _NAMES.items()},
        sequence=lambda values, kind: np.array(values, dtype=kind),
        flags=lambda values: np.array(values, dtype=bool),
        octet=int,
    )


def time_message(types: MessageTypes, stamp_ns: int) -> Any:
    """Return a time [ns] as a message."""
    sec, nanosec = divmod(int(stamp_ns), NS_PER_S)
    return types.Time(sec=sec, nanosec=nanosec)


def nanoseconds(stamp: Stamp) -> int:
    """Return a time message in ns."""
    return int(stamp.sec) * NS_PER_S + int(stamp.nanosec)


def axes(value: Value, dof: int) -> Any:
    """Return a signal's elements; a float stands for the same value on every axis."""
    if isinstance(value, np.ndarray) and value.ndim:
        return value.ravel()
    return (float(value),) * dof


def scalar(value: Value) -> float:
    """Return a quantity of the whole (an energy) that a law may keep as an array of one."""
    return float(value.ravel()[0]) if isinstance(value, np.ndarray) else float(value)
