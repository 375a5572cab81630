# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The fields of decoded messages that are read, whether rclpy or rosbags decoded them.

Units and meaning are those of the ``.msg`` files.
"""

from collections.abc import Sequence
from typing import Protocol

Numbers = Sequence[float]
# The signals of a trace, read and written by name.
PER_AXIS = ("x", "xd", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")  # of a tick
PER_TICK = {"lateness": "f", "compute": "f", "looked": "I"}  # typecodes
OF_OBJECT = ("x_o", "xd_o", "target")  # of a step


class Stamp(Protocol):
    """A time of ROS."""

    sec: int
    nanosec: int


class Trace(Protocol):
    """The fields that both traces have."""

    stamp: Stamp
    start_ns: int
    epoch: int
    period: float
    dof: int
    account_names: Sequence[str]
    accounts: Numbers
    changes: int
    taken_seq: Sequence[int]
    taken_epoch: Sequence[int]


class MasterTrace(Trace, Protocol):
    """A block of ticks; the signals of :class:`pmwvc_core.traces.UserTraces` are read by name."""

    first_tick: int
    state: int
    reason: str
    hand_force_known: bool
    f_h: Numbers
    lateness: Numbers
    looked: Sequence[int]
    taken_tick: Sequence[int]


class ServerTrace(Trace, Protocol):
    """A step of the server; signals of each user are read by name."""

    step: int
    users: Sequence[str]
    state: Sequence[int]
    lateness: float
    looked: int
    taken_user: Sequence[int]


class Wave(Protocol):
    """A packet."""

    epoch: int
    seq: int
    sent_ns: int
    period: float
    wave: Numbers
    integral: Numbers
    energy: float
    position: Numbers
    echo_seq: int
    echo_sent_ns: int
    echo_hold_ns: int
    flags: int


class LinkState(Protocol):
    """Counts, delays and settings of a link; they are read by name."""

    stamp: Stamp
    link: str


class Reception(Protocol):
    """Counts and delays of a receiver; they are read by name."""

    stamp: Stamp
    epoch: int
    seq: int
    link: str


class PacketFate(Protocol):
    """A block of records of a link; its columns are read by name."""

    stamp: Stamp
    link: str
    first: int
    epoch: Sequence[int]
    seq: Sequence[int]
    time_in_ns: Sequence[int]
