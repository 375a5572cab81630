# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Fates of packets as the feed takes them. No ROS is imported: messages are arguments."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pmwvc_core.numeric import Array


def packets_of(message: Any) -> Array:
    """Return a PacketFate as packets: number, time in and out [ns], fate."""
    count = len(message.time_in_ns)
    found = np.empty((count, 4))
    found[:, 0] = np.arange(message.first, message.first + count)
    for column, name in enumerate(("time_in_ns", "time_out_ns", "fate"), start=1):
        found[:, column] = np.asarray(getattr(message, name), dtype=np.float64)
    return found


def link_number(link: str, users: Sequence[str]) -> int | None:
    """Return the number of a link in snapshots; None for one that is no user's."""
    user, _, way = link.rpartition("/")
    if user not in users or way not in ("up", "down"):
        return None
    return 2 * list(users).index(user) + (way == "down")
