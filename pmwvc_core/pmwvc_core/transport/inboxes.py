# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What each end of a link expects of the other: one rule, live and in virtual time."""

from collections.abc import Iterable
from typing import NamedTuple

from pmwvc_core.params import SafetyParams
from pmwvc_core.transport.receiver import Receiver
from pmwvc_core.wave.impedance import Impedance
from pmwvc_core.wave.limits import largest_wave


class ServerTimes(NamedTuple):
    """Times of the server, one for all users: the longest of theirs [s]."""

    timeout_s: float
    release_s: float
    soft_start_s: float


def server_times(users: Iterable[SafetyParams]) -> ServerTimes:
    """Return when the server takes a user as silent and as gone, and when tasks begin."""
    all_users = list(users)
    return ServerTimes(
        *(max(float(getattr(user, name)) for user in all_users) for name in ServerTimes._fields)
    )


def inbox(
    dof: int, impedance: Impedance, *, waves: bool, period_s: float, timeout_s: float
) -> Receiver:
    """Return the receiver of a port of this impedance; it refuses waves that no sender means."""
    return Receiver(
        dof,
        period_s=period_s,
        timeout_s=timeout_s,
        max_wave=largest_wave(impedance, waves=waves),
    )
