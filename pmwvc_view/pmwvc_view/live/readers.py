# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Traces of the nodes as the feed takes them.

Any program of the domain can publish on these topics: bytes that are no message, a message whose
fields do not fit together, or of another shape than the session's, are skipped.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from rclpy.serialization import deserialize_message

from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.runtime.misfits import misfit
from pmwvc_msgs.msg import MasterTrace, ServerTrace
from pmwvc_view.feed.balances import NO_WAVES, ways
from pmwvc_view.feed.tape import AVATAR, F_H, NS, OBJECT, SIGNALS, TraceBlock, TraceStep

SAME_CLOCK_NS = 20_000_000  # clocks whose offsets differ by more are of two machines
OF_MESSAGE = ("x", "xd", "f_h", "f_applied", "u_m", "v_m")  # SIGNALS in a MasterTrace


class TraceReader:
    """The traces of a session with these users. ``clock_ns`` is by how much ROS time is ahead of
    the server's monotonic clock, as of the newest trace [ns]; None before.
    """

    def __init__(self, *, dof: int, users: Sequence[str], waves: bool) -> None:
        self._dof, self._users, self._waves = dof, list(users), waves
        self.clock_ns: int | None = None

    def block(self, data: bytes) -> TraceBlock | None:
        """Return a trace of a master as a block; None for one that is skipped. A master whose
        clock is of another machine is put beside the server's by ROS time, and its energy is not
        compared.
        """
        message = self._message(data, MasterTrace)
        if message is None or not math.isfinite(message.lateness[-1]):
            return None
        ticks = len(message.lateness)
        known = message.hand_force_known and len(message.f_h)
        every = [getattr(message, n) if n != "f_h" or known else message.x for n in OF_MESSAGE]
        signals = np.array(every).reshape(len(SIGNALS), ticks, self._dof)
        if not known:
            signals[F_H] = math.nan
        kept = dict(zip(message.account_names, message.accounts, strict=True))
        waves = message.energy_u_m, message.energy_u_tx, message.energy_v_m
        up_and_down = ways(*waves, kept) if self._waves else NO_WAVES
        offset_ns = _ahead_ns(message) - (self.clock_ns or 0)
        elsewhere = self.clock_ns is not None and abs(offset_ns) > SAME_CLOCK_NS
        return TraceBlock(
            start_ns=message.start_ns + (offset_ns if elsewhere else 0),
            period_ns=round(message.period * NS), signals=signals,
            lateness_s=message.lateness.tolist(), state=message.state, reason=message.reason,
            missed=message.missed, epoch=message.epoch,
            sums=None if elsewhere else (*up_and_down, message.energy_device),
        )  # fmt: skip

    def step(self, data: bytes) -> TraceStep | None:
        """Return a trace of the server as a step; None for one that is skipped."""
        message = self._message(data, ServerTrace)
        if message is None or message.users != self._users or not math.isfinite(message.lateness):
            return None
        self.clock_ns = _ahead_ns(message)
        avatars = np.array([getattr(message, name) for name in AVATAR])
        return TraceStep(
            start_ns=message.start_ns, epoch=message.epoch,
            object=np.array([getattr(message, name) for name in OBJECT]),
            avatars=avatars.reshape(len(AVATAR), len(self._users), self._dof),
            state=message.state, contact=message.contact, lateness_s=message.lateness,
            sums=np.array([message.energy_u_s, message.energy_v_s]),
        )  # fmt: skip

    def _message(self, data: bytes, kind: Any) -> Any:
        try:
            message = deserialize_message(data, kind)
        except (ValueError, RuntimeError):
            return None
        fits = message.dof == self._dof and misfit(kind.__name__, message) is None
        return message if fits else None


def _ahead_ns(message: Any) -> int:
    """Return by how much ROS time is ahead of the sender's monotonic clock [ns]."""
    return nanoseconds(message.stamp) - int(message.start_ns)
