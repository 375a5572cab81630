# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""When every master's block and every step of the server was, on the time line of the session.

The server's clock carries the time line; masters are aligned with it by echoes (alignment.py).
Without echoes every publisher's own wall time is all there is.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.recording.clocks import clock
from pmwvc_analysis.recording.clocks.alignment import Alignment, Integers, align
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.traces import FateTraces

WALL = Alignment("wall clock")
Seen = Sequence[tuple[int, Any]]  # log time [ns] and message
FAR_NS = 20_000_000  # a server's wall clock this far from the recorder's is not believed


class TimeLines(NamedTuple):
    """Times of the messages [ns], and per user how its clock was aligned."""

    masters: dict[str, Integers]
    server: Integers
    alignment: dict[str, dict[str, Any]]


def time_lines(
    by_topic: Mapping[str, Seen],
    masters: Mapping[str, Seen],
    server: Seen,
    fates: Mapping[str, FateTraces],
) -> TimeLines:
    """Return the times of all trace messages, in their order."""
    steps = [message for _, message in server]
    offset_ns = _offset_ns(server) if steps else 0
    found: dict[str, Integers] = {}
    said: dict[str, dict[str, Any]] = {}
    aligned = False
    for name, seen in masters.items():
        blocks = [message for _, message in seen]
        how = _align(name, by_topic, fates) if steps else None
        if how is None:
            found[name] = clock.start_times(blocks)
            said[name] = WALL.summary
        else:
            aligned = True
            found[name] = how.to_server(clock.monotonic_times(blocks)) + offset_ns
            said[name] = how.summary
    if not steps:
        return TimeLines(found, np.zeros(0, dtype=np.int64), said)
    own = clock.monotonic_times(steps) + offset_ns if aligned else clock.start_times(steps)
    return TimeLines(found, own, said)


def _align(
    name: str, by_topic: Mapping[str, Seen], fates: Mapping[str, FateTraces]
) -> Alignment | None:
    def sent(topic: str, relayed: str) -> list[Any]:
        return [message for _, message in by_topic.get(topic) or by_topic.get(relayed) or ()]

    return align(
        sent(f"/{name}/wave_up", f"/server/{name}/wave_up"),
        sent(f"/server/{name}/wave_down", f"/{name}/wave_down"),
        fates.get(f"{name}/up"),
        fates.get(f"{name}/down"),
    )


def _offset_ns(server: Seen) -> int:
    """Return what turns the server's monotonic clock into ROS time; by the recorder's clock where
    the server's own was set while running [ns].
    """
    monotonic = clock.monotonic_times([message for _, message in server])
    stamps = np.array([nanoseconds(message.stamp) for _, message in server], dtype=np.int64)
    logs = np.array([log_ns for log_ns, _ in server], dtype=np.int64)
    own, recorder = clock.offset_ns(monotonic, stamps), clock.offset_ns(monotonic, logs)
    return own if abs(own - recorder) <= FAR_NS else recorder
