# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The check that the fields of a trace, packet or link message fit together.

ROS checks types, not lengths: any program on the domain can publish a ``ServerTrace`` whose arrays
do not match. Readers of other programs' messages check them here first.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from pmwvc_core.network.in_flight import COLUMNS
from pmwvc_core.runtime.messages import OF_OBJECT, PER_AXIS
from pmwvc_core.traces import OF_AVATARS

# Messages that rclpy or rosbags decoded: classes that have nothing in common.
Trace: TypeAlias = Any  # MasterTrace or ServerTrace
MasterTrace: TypeAlias = Any
ServerTrace: TypeAlias = Any
Wave: TypeAlias = Any
LinkState: TypeAlias = Any
Reception: TypeAlias = Any
PacketFate: TypeAlias = Any
Stamp: TypeAlias = Any  # a time of ROS

MOST_DOF = 6
MOST_STATES = 4  # of MasterTrace and ServerTrace, 0 to 3
_LARGEST = 1 << 62  # numbers and times [ns] that overflow when they are added up


def misfit(kind: str, message: Any) -> str | None:
    """Return what does not fit in a message that rclpy or rosbags decoded, or None; of the types
    by name (``kind``) only those of ``pmwvc_msgs`` are looked into.
    """
    check = _CHECKS.get(kind)
    return check(message) if check else None


def _lengths(message: object, wanted: Mapping[str, int]) -> str | None:
    for name, length in wanted.items():
        if (found := len(getattr(message, name))) != length:
            return f"{name} has {found} values instead of {length}"
    return None


def _frame(message: Trace) -> str | None:
    """Check what both traces have: axes, period, clock, accounts."""
    if not 1 <= message.dof <= MOST_DOF:
        return f"dof = {message.dof}"
    if not (math.isfinite(message.period) and 0.0 < message.period <= 1.0):
        return f"period = {message.period:g} s"
    if abs(message.start_ns) >= _LARGEST:
        return f"start_ns = {message.start_ns}"
    if len(set(message.account_names)) != len(message.account_names):
        return "an account has the name of another"
    return _lengths(message, {"accounts": len(message.account_names)})


def _master_trace(message: MasterTrace) -> str | None:
    ticks = len(message.lateness)
    if not ticks or message.first_tick >= _LARGEST:
        return f"{ticks} ticks from {message.first_tick} on"
    if message.state >= MOST_STATES:
        return f"state = {message.state}"
    wanted = dict.fromkeys(PER_AXIS, ticks * message.dof) | {"compute": ticks}
    if not len(message.f_h):  # a hand that is not known may be left out
        del wanted["f_h"]
    return _frame(message) or _lengths(message, wanted) or _taken(message, "tick", ticks)


def _server_trace(message: ServerTrace) -> str | None:
    users = len(message.users)
    if message.step >= _LARGEST:
        return f"step = {message.step}"
    if not users or len(set(message.users)) != users:
        return f"{users} users"
    if max(message.state, default=0) >= MOST_STATES:
        return f"state = {max(message.state)}"
    wanted = dict.fromkeys(OF_OBJECT, message.dof)
    wanted |= dict.fromkeys(OF_AVATARS, users * message.dof)
    wanted |= dict.fromkeys(("state", "contact", "energy_u_s", "energy_v_s"), users)
    return _frame(message) or _lengths(message, wanted) or _taken(message, "user", users)


def _taken(message: Trace, place: str, count: int) -> str | None:
    """Check the packets taken in; a recording from before has none."""
    if not hasattr(message, "taken_seq"):
        return None
    places = getattr(message, f"taken_{place}")
    if max(places, default=0) >= count:
        return f"taken_{place} = {max(places)}"
    wanted = dict.fromkeys(("taken_seq", "taken_epoch"), len(places))
    return _lengths(message, wanted | ({"looked": count} if place == "tick" else {}))


def _wave(message: Wave) -> str | None:
    axes = len(message.wave)
    if not 1 <= axes <= MOST_DOF:
        return f"wave has {axes} values"
    return _lengths(message, {"integral": axes})


def _link(message: LinkState | Reception) -> str | None:
    return None if "/" in message.link else f"link = {message.link!r}"


def _packet_fate(message: PacketFate) -> str | None:
    if "/" not in message.link:
        return f"link = {message.link!r}"
    if not 1 <= message.first < _LARGEST:
        return f"first = {message.first}"
    return _lengths(message, dict.fromkeys(COLUMNS, len(message.epoch)))


_CHECKS: Mapping[str, Callable[[Any], str | None]] = {
    "MasterTrace": _master_trace,
    "ServerTrace": _server_trace,
    "Wave": _wave,
    "LinkState": _link,
    "PacketFate": _packet_fate,
    "Reception": _link,
}
