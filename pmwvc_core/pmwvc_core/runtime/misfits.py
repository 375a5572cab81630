# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The check that the fields of a trace, packet or link message fit together.

ROS checks types, not lengths: any program on the domain can publish a ``ServerTrace`` whose arrays
do not match. Readers of other programs' messages check them here first.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeAlias

from pmwvc_core.network.in_flight import COLUMNS
from pmwvc_core.numeric import AXES
from pmwvc_core.runtime.messages import OF_OBJECT, PER_AXIS
from pmwvc_core.traces import OF_AVATARS

# Messages that rclpy or rosbags decoded: classes that have nothing in common.
Trace: TypeAlias = Any  # MasterTrace or ServerTrace
MasterTrace: TypeAlias = Any
ServerTrace: TypeAlias = Any
Wave: TypeAlias = Any
Reception: TypeAlias = Any
PacketFate: TypeAlias = Any

MOST_STATES = 4  # of MasterTrace and ServerTrace, 0 to 3
_LARGEST = 1 << 62  # numbers and times [ns] that overflow when they are added up


def misfit(kind: str, message: Any) -> str | None:
    """Return what does not fit in a decoded message of the type ``kind``, or None."""
    return next(_CHECKS[kind](message), None) if kind in _CHECKS else None


# Each check yields the first misfit, then others that may follow from it.
def _lengths(message: object, wanted: Mapping[str, int]) -> Iterator[str]:
    for name, length in wanted.items():
        if (found := len(getattr(message, name))) != length:
            yield f"{name} has {found} values instead of {length}"


def _trace(message: Trace, wanted: Mapping[str, int], place: str, count: int) -> Iterator[str]:
    """Check what both traces have, lengths, and ``count`` ticks or users (``place``)."""
    if not 1 <= message.dof <= AXES:
        yield f"dof = {message.dof}"
    if not 0.0 < message.period <= 1.0:
        yield f"period = {message.period:g} s"
    if abs(message.start_ns) >= _LARGEST:
        yield f"start_ns = {message.start_ns}"
    names = message.account_names
    if len(set(names)) != len(names):
        yield "an account has the name of another"
    yield from _lengths(message, {"accounts": len(names), **wanted})
    places = getattr(message, f"taken_{place}")
    if max(places, default=0) >= count:
        yield f"taken_{place} = {max(places)}"
    looked = {"looked": count} if place == "tick" else {}
    taken = dict.fromkeys(("taken_seq", "taken_epoch"), len(places))
    yield from _lengths(message, taken | looked)


def _master_trace(message: MasterTrace) -> Iterator[str]:
    ticks = len(message.lateness)
    if not ticks or message.first_tick >= _LARGEST:
        yield f"{ticks} ticks from {message.first_tick} on"
    if message.state >= MOST_STATES:
        yield f"state = {message.state}"
    wanted = dict.fromkeys(PER_AXIS, ticks * message.dof) | {"compute": ticks}
    if not len(message.f_h):  # a hand that is not known may be left out
        del wanted["f_h"]
    yield from _trace(message, wanted, "tick", ticks)


def _server_trace(message: ServerTrace) -> Iterator[str]:
    users = len(message.users)
    if message.step >= _LARGEST:
        yield f"step = {message.step}"
    if not users or len(set(message.users)) != users:
        yield f"{users} users"
    if (state := max(message.state, default=0)) >= MOST_STATES:
        yield f"state = {state}"
    wanted = dict.fromkeys(OF_OBJECT, message.dof)
    wanted |= dict.fromkeys(OF_AVATARS, users * message.dof)
    wanted |= dict.fromkeys(("state", "contact", "energy_u_s", "energy_v_s"), users)
    wanted |= {"poses": 7 * len(message.bodies)} if hasattr(message, "bodies") else {}
    if len(getattr(message, "contacts", ())) % 8:
        yield f"contacts has {len(message.contacts)} values"
    yield from _trace(message, wanted, "user", users)


def _wave(message: Wave) -> Iterator[str]:
    axes = len(message.wave)
    if not 1 <= axes <= AXES:
        yield f"wave has {axes} values"
    yield from _lengths(message, {"integral": axes})


def _link(message: Reception | PacketFate) -> Iterator[str]:
    if "/" not in message.link:
        yield f"link = {message.link!r}"


def _packet_fate(message: PacketFate) -> Iterator[str]:
    yield from _link(message)
    if not 1 <= message.first < _LARGEST:
        yield f"first = {message.first}"
    yield from _lengths(message, dict.fromkeys(COLUMNS, len(message.epoch)))


_CHECKS: Mapping[str, Callable[[Any], Iterator[str]]] = {
    **{"MasterTrace": _master_trace, "ServerTrace": _server_trace, "Wave": _wave},
    **{"PacketFate": _packet_fate, "Reception": _link},
}
