# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The two clocks of a message, brought to the one time line of a session.

Records carry the monotonic clock of their host (even steps, no meaning across hosts) and ROS time
(of each host, may be set while running). Per publisher the difference of the two is taken
once, as its median, and added to the monotonic clock: intervals stay exact, and a clock that is
set does not bend the time line. Where the echoes of packets give it, only that of the server is
used, for all: the time lines of masters are aligned with it without wall time (alignment.py).
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.runtime.messages.fields import Stamp, Trace

Integers = NDArray[np.int64]


class _Stamped(Protocol):
    stamp: Stamp


def monotonic_times(messages: Sequence[Trace]) -> Integers:
    """Return the monotonic time of each trace message on its own host [ns]."""
    return np.array([message.start_ns for message in messages], dtype=np.int64)


def stamps(messages: Sequence[_Stamped]) -> Integers:
    """Return the ROS time of each message on its own host [ns]."""
    return np.array([nanoseconds(message.stamp) for message in messages], dtype=np.int64)


def start_times(messages: Sequence[Trace]) -> Integers:
    """Return the evenly stepped ROS time of each trace message [ns], epoch by epoch."""
    epochs = np.array([message.epoch for message in messages], dtype=np.uint64)
    monotonic, stamped = monotonic_times(messages), stamps(messages)
    result = np.zeros_like(monotonic)
    for epoch in np.unique(epochs):
        own = epochs == epoch
        result[own] = ros_times(monotonic[own], stamped[own])
    return result


def ros_times(monotonic_ns: Integers, stamp_ns: Integers) -> Integers:
    """Return evenly stepped ROS times of the instants that both clocks show [ns]."""
    if not len(monotonic_ns):
        return monotonic_ns
    return monotonic_ns + offset_ns(monotonic_ns, stamp_ns)


def offset_ns(monotonic_ns: Integers, stamp_ns: Integers) -> int:
    """Return what turns the monotonic clock into ROS time [ns]."""
    differences = np.sort(stamp_ns - monotonic_ns)
    return int(differences[len(differences) // 2])


def seconds(ros_ns: Integers, zero_ns: int) -> Array:
    """Return seconds since the start of the session."""
    return (ros_ns - zero_ns).astype(float) * 1e-9
