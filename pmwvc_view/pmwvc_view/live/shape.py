# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The places of the fields of a serialized message (CDR, little endian), learnt from one message
and valid for all of the same structure: reading them so costs a tenth of a message object.

The structure of a message is its encapsulation, its texts, the lengths of its sequences, and
numbers that its reader wants unchanged, up to a field from which on nothing is read. A message in
which any of it differs is another one's.
"""

import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from pmwvc_core.numeric import Array

HEAD = 4  # bytes of the encapsulation; fields are aligned from there
_CODES = {
    "boolean": "B", "uint8": "B", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q",
    "float": "f", "double": "d",
}  # fmt: skip


class Shape:
    """The structure of a message, from its bytes and the same as the middleware reads it.

    ``same`` are the names of the numbers and sequences that belong to the structure; ``numbers``
    those to be read, also sequences, in the order of the message (a field in another has its name
    in front); ``arrays`` the sequences of ``double`` to be read; ``before`` the field from which
    on nothing is read and lengths may differ.
    """

    def __init__(
        self, data: bytes, message: Any, *, same: Sequence[str], numbers: Sequence[str],
        arrays: Sequence[str], before: str,
    ) -> None:  # fmt: skip
        self._at = HEAD
        self._places: dict[str, tuple[int, int, str]] = {}  # offset, count, code
        self._fixed = list(range(HEAD))
        self._find(message, "", end=before)
        for name in same:
            at, count, code = self._places[name]
            self._fix(at, count * struct.calcsize(code))
        self._length = self._at
        self._where = np.array(self._fixed)
        self._structure = self._bytes(data)
        layout, at = "<", 0
        for name in numbers:
            begin, count, code = self._places[name]
            layout += f"{begin - at}x{count}{code}"
            at = begin + count * struct.calcsize(code)
        self._numbers = struct.Struct(layout)
        self._doubles = (self._length - HEAD) // 8
        places = (self._places[name] for name in arrays)
        self._index = np.concatenate([(at - HEAD) // 8 + np.arange(n) for at, n, _ in places])

    def holds(self, data: bytes) -> bool:
        """Tell whether a message has this structure."""
        return len(data) >= self._length and self._bytes(data) == self._structure

    def _bytes(self, data: bytes) -> bytes:
        """Return those bytes of a message that belong to its structure."""
        return np.frombuffer(data, np.uint8).take(self._where).tobytes()

    def numbers(self, data: bytes) -> tuple[Any, ...]:
        """Return the numbers of a message of this structure."""
        return self._numbers.unpack_from(data)

    def arrays(self, data: bytes) -> Array:
        """Return the arrays of a message of this structure, one after the other."""
        return np.frombuffer(data, "<f8", self._doubles, HEAD).take(self._index)

    def _find(self, message: Any, before: str, *, end: str = "") -> None:
        """Note the places of the fields of a message up to ``end``, or of a field of it."""
        for name, kind in message.get_fields_and_field_types().items():
            if name == end:
                return
            value = getattr(message, name)
            if "/" in kind:
                self._find(value, f"{before}{name}.")
            elif kind == "string":
                self._text(value)
            elif kind.startswith("sequence<"):
                self._fix(self._aligned(4), 4)
                self._at += 4
                if kind == "sequence<string>":
                    for each in value:
                        self._text(each)
                else:
                    self._place(before + name, len(value), _CODES[kind[len("sequence<") : -1]])
            else:
                self._place(before + name, 1, _CODES[kind])

    def _place(self, name: str, count: int, code: str) -> None:
        size = struct.calcsize(code)
        if count:
            self._aligned(size)
        self._places[name] = self._at, count, code
        self._at += count * size

    def _text(self, value: str) -> None:
        begin = self._aligned(4)
        self._at += 4 + len(value.encode()) + 1
        self._fix(begin, self._at - begin)

    def _aligned(self, size: int) -> int:
        self._at += -(self._at - HEAD) % size
        return self._at

    def _fix(self, at: int, size: int) -> None:
        self._fixed.extend(range(at, at + size))
