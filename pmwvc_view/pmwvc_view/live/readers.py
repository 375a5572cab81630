# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Readers of serialized traces (CDR, little endian): bytes to the feed's blocks and steps.

Any program of the domain can publish on these topics: a message whose fields do not fit together,
or of another shape than the session's, is skipped. The places of the fields are learnt from one
message and valid for all of the same structure: reading them so costs a tenth of a message object.
"""

import math
import struct
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message

from pmwvc_core.numeric import Array
from pmwvc_core.runtime.misfits import misfit
from pmwvc_msgs.msg import MasterTrace, ServerTrace
from pmwvc_view.feed.accounts import NO_WAVES, MasterSums, ServerSums, ways
from pmwvc_view.feed.traces import AVATAR, F_H, NS, OBJECT, SIGNALS, TraceBlock, TraceStep

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


SAME_CLOCK_NS = 20_000_000  # clocks whose offsets differ by more are of two machines
LARGEST_NS = 1 << 62


class _TraceReader:
    """The part common to the readers of both kinds: what of a message is read."""

    KIND: ClassVar[Any]
    SAME: ClassVar[Sequence[str]]
    NUMBERS: ClassVar[Sequence[str]]
    ARRAYS: ClassVar[Sequence[str]]

    def __init__(self, dof: int) -> None:
        self._dof = dof
        self._shape: Shape | None = None
        self._known: Any = None  # the message that the shape was learnt from

    def _learnt(self, data: bytes) -> bytes | None:
        """Return a message as its shape reads it, the shape learnt from it where need be; None
        for one that is skipped.
        """
        if self._shape is not None and self._shape.holds(data):
            return data
        try:
            message = deserialize_message(data, self.KIND)
        except (ValueError, RuntimeError):
            return None
        if message.dof != self._dof or misfit(self.KIND.__name__, message):
            return None
        own: bytes = serialize_message(message)  # whatever encoding it came in
        # The force of a hand that is not known may be left out.
        arrays = [name if name != "f_h" or message.f_h else "x" for name in self.ARRAYS]
        names = {"same": self.SAME, "numbers": self.NUMBERS, "arrays": arrays}
        self._known, self._shape = message, Shape(own, message, before="changes", **names)
        return own


class MasterReader(_TraceReader):
    """The traces of one master."""

    KIND = MasterTrace
    SAME = ("period", "dof", "state", "hand_force_known")
    NUMBERS = (
        *("stamp.sec", "stamp.nanosec", "start_ns", "epoch", "missed", "lateness"),
        *("energy_u_m", "energy_u_tx", "energy_v_m", "energy_device", "accounts"),
    )
    ARRAYS = ("x", "xd", "f_h", "f_applied", "u_m", "v_m")

    def __init__(self, *, dof: int, waves: bool) -> None:
        super().__init__(dof)
        self._waves = waves

    def read(self, data: bytes, clock_ns: int | None) -> TraceBlock | None:
        """Return a trace as a block; None for one that is skipped.

        ``clock_ns`` is by how much ROS time is ahead of the server's monotonic clock [ns], where
        it is known. A master whose clock is of another machine is put beside it by ROS time, and
        its energy is not compared.
        """
        if (found := self._learnt(data)) is None or self._shape is None:
            return None
        known, numbers = self._known, self._shape.numbers(found)
        names = known.account_names
        sec, nanosec, start_ns, epoch, missed, *rest = numbers[: len(numbers) - len(names)]
        *late, u_m, u_tx, v_m, device = rest
        if not -LARGEST_NS < start_ns < LARGEST_NS or not math.isfinite(late[-1]):
            return None
        signals = self._shape.arrays(found).reshape(len(SIGNALS), len(late), self._dof)
        if not (known.hand_force_known and len(known.f_h)):
            signals[F_H] = math.nan
        period_ns = round(known.period * NS)
        ran_ns = start_ns + (len(late) - 1) * period_ns + round(late[-1] * NS)
        kept = dict(zip(names, numbers[len(numbers) - len(names) :], strict=True))
        up, down = ways(u_m, u_tx, v_m, kept) if self._waves else NO_WAVES
        sums: MasterSums | None = MasterSums(ran_ns, epoch, up, down, device)
        offset_ns = sec * NS + nanosec - start_ns
        if clock_ns is not None and abs(offset_ns - clock_ns) > SAME_CLOCK_NS:
            start_ns += offset_ns - clock_ns
            sums = None
        return TraceBlock(
            start_ns=start_ns, period_ns=period_ns, signals=signals, lateness_s=late,
            state=known.state, reason=known.reason, missed=missed, sums=sums,
        )  # fmt: skip


class ServerReader(_TraceReader):
    """The traces of the server. ``clock_ns`` is by how much ROS time is ahead of the server's
    monotonic clock, as of the newest trace [ns]; None before.
    """

    KIND = ServerTrace
    SAME = ("period", "dof", "state", "contact")
    NUMBERS = (
        *("stamp.sec", "stamp.nanosec", "start_ns", "epoch"),
        *("energy_u_s", "energy_v_s", "lateness"),
    )
    ARRAYS = (*OBJECT, *AVATAR)

    def __init__(self, *, dof: int, users: Sequence[str]) -> None:
        super().__init__(dof)
        self._users = users
        self.clock_ns: int | None = None

    def read(self, data: bytes) -> TraceStep | None:
        """Return a trace as a step; None for one that is skipped."""
        found, users = self._learnt(data), self._users
        if found is None or self._shape is None or self._known.users != users:
            return None
        sec, nanosec, start_ns, epoch, *energy, late_s = self._shape.numbers(found)
        if not -LARGEST_NS < start_ns < LARGEST_NS or not math.isfinite(late_s):
            return None
        self.clock_ns = sec * NS + nanosec - start_ns
        arrays, own = self._shape.arrays(found), len(OBJECT) * self._dof
        ran_ns = start_ns + round(late_s * NS)
        each = zip(users, energy[: len(users)], energy[len(users) :], strict=True)
        return TraceStep(
            start_ns=start_ns, object=arrays[:own].reshape(len(OBJECT), self._dof),
            avatars=arrays[own:].reshape(len(AVATAR), len(users), self._dof),
            state=self._known.state, contact=self._known.contact, lateness_s=late_s,
            sums={name: ServerSums(ran_ns, epoch, u_s, v_s) for name, u_s, v_s in each},
        )  # fmt: skip
