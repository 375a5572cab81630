# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The times of every master's blocks and of every step of the server on the session's time line.

The server's clock carries the time line; masters are aligned with it by echoes (alignment.py).
Without echoes every publisher's own wall time is all there is.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.recording.clocks import clock
from pmwvc_analysis.recording.clocks.alignment import Alignment, Integers, align
from pmwvc_core.runtime.messages.fields import MasterTrace, ServerTrace, Wave
from pmwvc_core.traces import FateTraces

WALL = Alignment("wall clock")
LARGEST_OFFSET_NS = 20_000_000  # a server's wall clock this far from the recorder's is wrong


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
    offset_ns = _offset_ns(steps, np.array(steps_log_ns, dtype=np.int64)) if steps else 0
    times: dict[str, Integers] = {}
    alignment: dict[str, Alignment] = {}
    for name, blocks in masters.items():
        found = _align(name, waves, fates) if steps else None
        alignment[name] = found or WALL
        times[name] = (
            found.to_server(clock.monotonic_times(blocks)) + offset_ns
            if found
            else clock.start_times(blocks)
        )
    aligned = any(found is not WALL for found in alignment.values())
    server = clock.monotonic_times(steps) + offset_ns if aligned else clock.start_times(steps)
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
    monotonic = clock.monotonic_times(steps)
    own = clock.offset_ns(monotonic, clock.stamps(steps))
    recorder = clock.offset_ns(monotonic, logs)
    return own if abs(own - recorder) <= LARGEST_OFFSET_NS else recorder
