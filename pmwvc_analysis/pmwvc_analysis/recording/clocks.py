# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The clocks of a recording, brought to one time line.

Records carry the monotonic clock of their host (even steps, no meaning across hosts) and ROS time
(of each host, may be set while running). Per publisher the median of their difference is added to
the monotonic clock: intervals stay exact, and a clock that is set does not bend the time line.

Between hosts the echoes of packets align the clock of each master with that of the server. A
packet names the newest one of the peer: its number, the peer's clock when it was sent, and how
long it waited. With the server's clock S and the master's clock M, theta = S - M,

    up   = (sent_S - hold) - echo_sent_M = delay up   + theta     (packets of the server)
    down = (sent_M - hold) - echo_sent_S = delay down - theta     (packets of the master)

No delay is below zero, and the delays that an emulated link recorded are taken off. Over a window
the least of each stays, -min(down) <= theta <= min(up). Where theta = 0 fits, both run on one
host; else theta follows the line of :mod:`pmwvc_core.transport.path`: hosts drift.

Equations: docs/theory.md 13.8.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array, Integers
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.runtime.misfits import MasterTrace, ServerTrace, Trace, Wave
from pmwvc_core.traces import FateTraces
from pmwvc_core.transport.path import Shortest, latest_line

WINDOW_NS = 1_000_000_000
MOST_WINDOWS = 120  # longer sessions have longer windows
ONE_HOST, ECHO = "one host", "echo"
LEAST_PAIRS = 8  # in a window, either way
LARGEST_OFFSET_NS = 20_000_000  # of a publisher's clock from the recorder's; set by less: jitter


class Alignment(NamedTuple):
    """theta(t) = ``offset_ns`` + ``rate`` (t - ``at_ns``), t on the master's clock [ns]."""

    how: str
    offset_ns: float = 0.0
    rate: float = 0.0
    at_ns: int = 0
    uncertainty_s: float = 0.0

    def to_server(self, master_ns: Integers) -> Integers:
        """Return instants of the master's clock on the server's [ns]."""
        shift = self.offset_ns + self.rate * (master_ns - self.at_ns).astype(float)
        return master_ns + np.round(shift).astype(np.int64)

    @property
    def summary(self) -> dict[str, str | float]:
        """Return it as plain numbers."""
        offset_s, drift_ppm = self.offset_ns * 1e-9, self.rate * 1e6
        how, open_s = self.how, self.uncertainty_s
        return {"how": how, "offset_s": offset_s, "drift_ppm": drift_ppm, "uncertainty_s": open_s}


def monotonic_times(messages: Sequence[Trace]) -> Integers:
    """Return the monotonic time of each trace message on its own host [ns]."""
    return np.array([message.start_ns for message in messages], dtype=np.int64)


def stamps(messages: Sequence[Trace]) -> Integers:
    """Return the ROS time of each message on its own host [ns]."""
    return np.array([nanoseconds(message.stamp) for message in messages], dtype=np.int64)


def start_times(messages: Sequence[Trace]) -> Integers:
    """Return the evenly stepped ROS time of each trace message [ns], epoch by epoch."""
    epochs = np.array([message.epoch for message in messages], dtype=np.uint64)
    result, stamped = monotonic_times(messages), stamps(messages)
    for epoch in np.unique(epochs):
        own = epochs == epoch
        result[own] += offset_ns(result[own], stamped[own])
    return result


def offset_ns(monotonic_ns: Integers, stamp_ns: Integers) -> int:
    """Return what turns the monotonic clock into ROS time [ns]."""
    return int(np.sort(stamp_ns - monotonic_ns)[len(stamp_ns) // 2])


def trusted_times(own_ns: Sequence[int] | Integers, log_ns: Sequence[int] | Integers) -> Integers:
    """Return instants by the clock of their publisher, which has them better than a recorder
    that has to wait for the processor; those of recording where both clocks differ by more than
    the recorder was late, or the publisher's was set [ns].
    """
    own, late_ns = np.array(own_ns, dtype=float), np.subtract(log_ns, own_ns, dtype=float)
    one_clock = 0.0 <= late_ns.min() < max(LARGEST_OFFSET_NS, np.ptp(late_ns))
    was_set = (np.diff(own) < -LARGEST_OFFSET_NS).any()
    return np.array(own_ns if one_clock and not was_set else log_ns, dtype=np.int64)


def seconds(ros_ns: Integers, zero_ns: int) -> Array:
    """Return seconds since the start of the session."""
    return (ros_ns - zero_ns).astype(float) * 1e-9


def time_lines(
    masters: Mapping[str, Sequence[MasterTrace]],
    steps: Sequence[ServerTrace],
    steps_log_ns: Sequence[int],
    waves: Mapping[str, Sequence[Wave]],
    fates: Mapping[str, FateTraces],
) -> tuple[dict[str, Integers], Integers, dict[str, dict[str, str | float]]]:
    """Return the times of all trace messages of the masters and of the server, in their order
    [ns], and per user how its clock was aligned; packets are by topic.
    """
    alignment: dict[str, Alignment] = {}
    for name in masters if steps else ():  # by the packets as sent, else as out of their link
        up = waves.get(f"/{name}/wave_up") or waves.get(f"/server/{name}/wave_up", ())
        down = waves.get(f"/server/{name}/wave_down") or waves.get(f"/{name}/wave_down", ())
        if found := align(up, down, fates.get(f"{name}/up"), fates.get(f"{name}/down")):
            alignment[name] = found
    server, ahead_ns = start_times(steps), 0
    if alignment:
        monotonic = monotonic_times(steps)
        ahead_ns = offset_ns(monotonic, trusted_times(stamps(steps), steps_log_ns))
        server = monotonic + ahead_ns
    times = {
        name: alignment[name].to_server(monotonic_times(blocks)) + ahead_ns
        if name in alignment
        else start_times(blocks)
        for name, blocks in masters.items()
    }
    wall = Alignment("wall clock")
    return times, server, {name: alignment.get(name, wall).summary for name in masters}


def align(
    of_master: Sequence[Wave],
    of_server: Sequence[Wave],
    up: FateTraces | None = None,
    down: FateTraces | None = None,
) -> Alignment | None:
    """Return the alignment of a master's clock with the server's (13.8); None without echoes.

    From their Wave messages, as sent, and what the emulated link up and down did to the packets.
    """
    # Of the master's packets, by the server's echoes; and of the server's. Times: the master's.
    rising = _passages([(m, m.echo_sent_ns) for m in of_server], _delays(up))
    falling = _passages([(m, m.sent_ns - m.echo_hold_ns) for m in of_master], _delays(down))
    if min(len(rising), len(falling)) < LEAST_PAIRS:
        return None
    first, last = int(rising[:, 0].min()), int(rising[:, 0].max())
    window_ns = max(WINDOW_NS, (last - first) // MOST_WINDOWS)
    windows = []
    for start in range(first, last + 1, window_ns):
        parts = [
            way[(way[:, 0] >= start) & (way[:, 0] < start + window_ns)]
            for way in (rising, falling)
        ]
        if min(map(len, parts)) >= LEAST_PAIRS:
            up_least, down_least = (part[np.argmin(part[:, 1])].tolist() for part in parts)
            windows.append((Shortest(*up_least), Shortest(*down_least)))
    if (found := latest_line(windows)) is None:
        return None
    line, before = found
    if line.one_clock:
        return Alignment(ONE_HOST)
    open_ns = line.open_ns + line.rate_open * window_ns / 2.0
    most_ns = open_ns
    for out, into in windows[:before]:  # other delays than those of the line
        over = out.passage_ns - line.theta_ns(out.at_ns)
        under = into.passage_ns + line.theta_ns(into.at_ns)
        drifted = open_ns + line.rate_open * abs(out.at_ns - line.at_ns)
        most_ns = max(most_ns, min(max(abs(over), abs(under)), drifted))
    return Alignment(ECHO, line.offset_ns, line.rate, line.at_ns, most_ns * 1e-9)


def _passages(echoes: Sequence[tuple[Wave, int]], delays: Mapping[int, int]) -> Integers:
    """Return per echo when its packet passed, on the master's clock, and its passage by both
    clocks less its delay in the emulated link [ns] ``(packet, 2)``.
    """
    rows = [
        (int(at_ns), int(m.sent_ns - m.echo_hold_ns - m.echo_sent_ns) - delays.get(m.echo_seq, 0))
        for m, at_ns in echoes
        if m.echo_seq > 0
    ]
    return np.array(rows, dtype=np.int64).reshape(-1, 2)


def _delays(fates: FateTraces | None) -> dict[int, int]:
    """Return the least delay of every packet that came out of a link, by its number [ns]."""
    if fates is None or len(np.unique(fates.epoch)) > 1:
        return {}
    out = fates.time_out_ns > 0
    seq, took = fates.seq[out], (fates.time_out_ns - fates.time_in_ns)[out]
    longest_first = np.argsort(-took, kind="stable")  # the last of a number stays
    return dict(zip(seq[longest_first].tolist(), took[longest_first].tolist(), strict=True))
