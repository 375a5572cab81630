# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The times of the server, made from those of its users."""

from collections.abc import Iterable
from typing import NamedTuple

from pmwvc_core.params import SafetyParams


class ServerTimes(NamedTuple):
    """Times of the server, one for all users: the longest of theirs [s]."""

    timeout_s: float
    release_s: float
    soft_start_s: float


def server_times(users: Iterable[SafetyParams]) -> ServerTimes:
    """Return when the server takes a user as silent and as gone, and when tasks begin."""
    each = list(users)
    return ServerTimes(
        *(max(float(getattr(user, name)) for user in each) for name in ServerTimes._fields)
    )
