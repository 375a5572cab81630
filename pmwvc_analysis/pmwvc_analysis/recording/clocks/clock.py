# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The two clocks of a message, brought to the one time line of a session.

Records carry the monotonic clock of their host (even steps, no meaning across hosts) and ROS time
(of each host, may be set while running). Per publisher the difference of the two is taken
once, as its median, and added to the monotonic clock: intervals stay exact, and a clock that is
set does not bend the time line. Where the echoes of packets give it, only that of the server is
used, for all: the time lines of masters are aligned with it without wall time (alignment.py).
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from pmwvc_analysis.recording.clocks.alignment import Alignment, align
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.runtime.messages.fields import MasterTrace, ServerTrace, Stamp, Trace, Wave
from pmwvc_core.traces import FateTraces

WALL = Alignment("wall clock")
LARGEST_OFFSET_NS = 20_000_000  # a server's wall clock this far from the recorder's is wrong


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
        result[own] = monotonic[own] + offset_ns(monotonic[own], stamped[own])
    return result


def offset_ns(monotonic_ns: Integers, stamp_ns: Integers) -> int:
    """Return what turns the monotonic clock into ROS time [ns]."""
    differences = np.sort(stamp_ns - monotonic_ns)
    return int(differences[len(differences) // 2])


def seconds(ros_ns: Integers, zero_ns: int) -> Array:
    """Return seconds since the start of the session."""
    return (ros_ns - zero_ns).astype(float) * 1e-9


class TimeLines(NamedTuple):
    """Times of the messages [ns], and per user how its clock was aligned."""

    masters: dict[str, Integers]
    server: Integers
    alignment: dict[str, dict[str, str | float]]


def time_lines(
    masters: Mapping[str, Sequence[MasterTrace]],
    steps: Sequence[ServerTrace],
    steps_log_ns: Sequence[int],
    waves: Mapping[str, Sequence[Wave]],
    fates: Mapping[str, FateTraces],
) -> TimeLines:
    """Return the times of all trace messages, in their order; packets are by topic."""
    ahead_ns = _offset_ns(steps, np.array(steps_log_ns, dtype=np.int64)) if steps else 0
    times: dict[str, Integers] = {}
    alignment: dict[str, Alignment] = {}
    for name, blocks in masters.items():
        found = _align(name, waves, fates) if steps else None
        alignment[name] = found or WALL
        times[name] = (
            found.to_server(monotonic_times(blocks)) + ahead_ns if found else start_times(blocks)
        )
    aligned = any(found is not WALL for found in alignment.values())
    server = monotonic_times(steps) + ahead_ns if aligned else start_times(steps)
    return TimeLines(times, server, {name: found.summary for name, found in alignment.items()})


def _align(
    name: str, waves: Mapping[str, Sequence[Wave]], fates: Mapping[str, FateTraces]
) -> Alignment | None:
    """Align a user's clock by the packets as sent, else as they came out of their link."""
    own, servers = f"/{name}/wave_", f"/server/{name}/wave_"
    return align(
        waves.get(f"{own}up") or waves.get(f"{servers}up") or (),
        waves.get(f"{servers}down") or waves.get(f"{own}down") or (),
        fates.get(f"{name}/up"),
        fates.get(f"{name}/down"),
    )


def _offset_ns(steps: Sequence[ServerTrace], logs: Integers) -> int:
    """Return what turns the server's monotonic clock into ROS time; by the recorder's clock where
    the server's own was set while running [ns].
    """
    monotonic = monotonic_times(steps)
    own = offset_ns(monotonic, stamps(steps))
    recorder = offset_ns(monotonic, logs)
    return own if abs(own - recorder) <= LARGEST_OFFSET_NS else recorder
