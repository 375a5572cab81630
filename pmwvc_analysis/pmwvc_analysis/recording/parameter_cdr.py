# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Serialized ``rcl_interfaces/msg/ParameterEvent`` messages (CDR), read without ROS.

rosbags cannot: it expects padding in front of an empty sequence of 8-byte numbers, which Fast DDS
does not write. Only parameters that changed are returned.
"""

import struct
from dataclasses import dataclass, field
from typing import Any

_NS_PER_S = 10**9
_LONGEST = 100_000  # parameters or elements; more is no message of ours


@dataclass(frozen=True)
class ParameterChange:
    """Values that a node changed together; a value that is a list is "a list"."""

    at_ns: int
    node: str
    values: dict[str, Any] = field(default_factory=dict)


class _Reader:
    """Reads one message after the other field; alignment counts from behind the encapsulation."""

    def __init__(self, data: bytes) -> None:
        self._data = data[4:]
        self._order = "<" if data[1] == 1 else ">"
        self._at = 0

    def number(self, code: str) -> Any:
        size = struct.calcsize(code)
        self._at += -self._at % size
        (value,) = struct.unpack_from(self._order + code, self._data, self._at)
        self._at += size
        return value

    def count(self) -> int:
        count: int = self.number("I")
        if count > _LONGEST:
            raise ValueError(f"{count} elements")
        return count

    def text(self) -> str:
        length = self.count()
        raw = self._data[self._at : self._at + length]
        self._at += length
        return raw.rstrip(b"\0").decode("utf-8", errors="replace")

    def numbers(self, code: str) -> None:
        for _ in range(self.count()):
            self.number(code)

    def parameters(self) -> dict[str, Any]:
        return dict((self.text(), self.value()) for _ in range(self.count()))

    def value(self) -> Any:
        kind = self.number("B")
        plain = {1: bool(self.number("B")), 2: self.number("q"), 3: self.number("d")}
        plain[4] = self.text()
        for code in "B?qd":
            self.numbers(code)
        for _ in range(self.count()):
            self.text()
        return plain.get(kind, "a list")


def parameter_change(data: bytes) -> ParameterChange | None:
    """Return a message's changed parameters, or None where it is no such message."""
    try:
        reader = _Reader(data)
        seconds, nanoseconds, node = reader.number("i"), reader.number("I"), reader.text()
        reader.parameters()  # new ones
        values = reader.parameters()
    except (struct.error, ValueError, IndexError):
        return None
    return ParameterChange(seconds * _NS_PER_S + nanoseconds, node, values)
