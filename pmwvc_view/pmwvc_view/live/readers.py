# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Readers of serialized traces: bytes to the blocks and steps that the feed takes.

Any program of the domain can publish on these topics: a message whose fields do not fit together,
or of another shape than the session's, is skipped.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar

from rclpy.serialization import deserialize_message, serialize_message

from pmwvc_core.runtime.misfits import misfit
from pmwvc_msgs.msg import MasterTrace, ServerTrace
from pmwvc_view.feed.accounts import NO_WAVES, MasterSums, ServerSums, ways
from pmwvc_view.feed.traces import AVATAR, F_H, NS, OBJECT, SIGNALS, Block, Step
from pmwvc_view.live.shape import Shape

SAME_CLOCK_NS = 20_000_000  # clocks whose offsets differ by more are of two machines
LARGEST_NS = 1 << 62


class _Reader(ABC):
    """The part common to the readers of both kinds."""

    KIND: ClassVar[Any]
    SAME: ClassVar[Sequence[str]]
    NUMBERS: ClassVar[Sequence[str]]

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
        names = {"same": self.SAME, "numbers": self.NUMBERS, "arrays": self._arrays(message)}
        self._known, self._shape = message, Shape(own, message, before="changes", **names)
        return own

    @abstractmethod
    def _arrays(self, message: Any) -> Sequence[str]:
        """Return the names of the arrays to be read."""


class MasterReader(_Reader):
    """The traces of one master."""

    KIND = MasterTrace
    SAME = ("period", "dof", "state", "hand_force_known")
    NUMBERS = (
        *("stamp.sec", "stamp.nanosec", "start_ns", "epoch", "missed", "lateness"),
        *("energy_u_m", "energy_u_tx", "energy_v_m", "energy_device", "accounts"),
    )

    def __init__(self, *, dof: int, waves: bool) -> None:
        super().__init__(dof)
        self._waves = waves

    def _arrays(self, message: Any) -> Sequence[str]:
        hand = "f_h" if len(message.f_h) else "x"  # one that is not known may be left out
        return "x", "xd", hand, "f_applied", "u_m", "v_m"

    def read(self, data: bytes, clock_ns: int | None) -> Block | None:
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
        return Block(
            start_ns=start_ns, period_ns=period_ns, signals=signals, lateness_s=late,
            state=known.state, reason=known.reason, missed=missed, sums=sums,
        )  # fmt: skip


class ServerReader(_Reader):
    """The traces of the server. ``clock_ns`` is by how much ROS time is ahead of the server's
    monotonic clock, as of the newest trace [ns]; None before.
    """

    KIND = ServerTrace
    SAME = ("period", "dof", "state", "contact")
    NUMBERS = (
        *("stamp.sec", "stamp.nanosec", "start_ns", "epoch"),
        *("energy_u_s", "energy_v_s", "lateness"),
    )

    def __init__(self, *, dof: int, users: Sequence[str]) -> None:
        super().__init__(dof)
        self._users = users
        self.clock_ns: int | None = None

    def _arrays(self, message: Any) -> Sequence[str]:
        return *OBJECT, *AVATAR

    def read(self, data: bytes) -> Step | None:
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
        return Step(
            start_ns=start_ns, object=arrays[:own].reshape(len(OBJECT), self._dof),
            avatars=arrays[own:].reshape(len(AVATAR), len(users), self._dof),
            state=self._known.state, contact=self._known.contact, lateness_s=late_s,
            sums={name: ServerSums(ran_ns, epoch, u_s, v_s) for name, u_s, v_s in each},
        )  # fmt: skip
