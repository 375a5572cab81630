# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The clock of each master against that of the server, from the echoes of their packets.

Records carry the monotonic clock of their host. On one host that clock is common to all; between
hosts wall clocks differ, and may be set while running, so they are not used. A packet names the
newest one of the peer: its number, the peer's clock when it was sent, and how long it waited. With
the server's clock S and the master's clock M, theta = S - M,

    up   = (sent_S - hold) - echo_sent_M = delay up   + theta     (packets of the server)
    down = (sent_M - hold) - echo_sent_S = delay down - theta     (packets of the master)

No delay is below zero, and an emulated link records the delay of every packet, which is taken off.
Over a window the least of each stays, as in NTP:

    -min(down) <= theta <= min(up),     theta = (min(up) - min(down))/2 +- (min(up) + min(down))/2

Where theta = 0 fits all windows, both run on one host: there is nothing to align. Otherwise theta
follows a straight line through the windows: hosts drift.

Equations: docs/theory.md 13.10.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.runtime.messages.fields import Wave
from pmwvc_core.traces import FateTraces
from pmwvc_core.transport.clock_line import one_clock

Integers = NDArray[np.int64]
WINDOW_NS = 10_000_000_000
ONE_HOST, ECHO = "one host", "echo"
LEAST_PAIRS = 8  # in a window, either way


@dataclass(frozen=True)
class Alignment:
    """theta(t) = ``offset_ns`` + ``rate`` (t - ``at_ns``), t on the master's clock [ns]."""

    how: str
    offset_ns: float = 0.0
    rate: float = 0.0
    at_ns: int = 0
    uncertainty_s: float = 0.0

    def to_server(self, master_ns: Integers) -> Integers:
        """Return instants of the master's clock on the server's [ns]."""
        if self.how == ONE_HOST:
            return master_ns
        shift = self.offset_ns + self.rate * (master_ns - self.at_ns).astype(float)
        return master_ns + np.round(shift).astype(np.int64)

    @property
    def summary(self) -> dict[str, str | float]:
        """Return it as plain numbers."""
        return {
            "how": self.how,
            "offset_s": self.offset_ns * 1e-9,
            "drift_ppm": self.rate * 1e6,
            "uncertainty_s": self.uncertainty_s,
        }


def align(
    of_master: Sequence[Wave],
    of_server: Sequence[Wave],
    up: FateTraces | None = None,
    down: FateTraces | None = None,
) -> Alignment | None:
    """Return the alignment of a master's clock with the server's; None without echoes.

    From their Wave messages, as sent, and what the emulated link up and down did to the packets.
    """
    rising = _passages(of_server, _delays(up))  # of the master's packets, seen at the server
    falling = _passages(of_master, _delays(down))
    if min(len(rising), len(falling)) < LEAST_PAIRS:
        return None
    first, last = int(rising[:, 0].min()), int(rising[:, 0].max())
    if one_clock(int(rising[:, 1].min()), int(falling[:, 1].min())):
        return Alignment(ONE_HOST)
    edges = np.arange(first, last + WINDOW_NS, WINDOW_NS)
    guess = (int(rising[:, 1].min()) - int(falling[:, 1].min())) // 2
    found = []
    for start in edges.tolist():
        ups = _within(rising, start, start + WINDOW_NS)
        downs = _within(falling, start + guess, start + guess + WINDOW_NS)
        if min(len(ups), len(downs)) >= LEAST_PAIRS:
            least_up, least_down = int(ups.min()), int(downs.min())
            middle = start + WINDOW_NS // 2 - first
            theta, half = (least_up - least_down) / 2.0, (least_up + least_down) / 2.0
            found.append((float(middle), theta, max(half, 0.0)))
    if not found:
        return None
    return _line(np.array(found), first)


def _line(windows: NDArray[np.float64], first_ns: int) -> Alignment:
    """Return theta as a straight line through the windows, with what it leaves open."""
    times, thetas, halves = windows.T
    at_s, rate = float(times.mean()), 0.0
    if len(windows) >= 3:
        rate = float(np.polyfit(times - at_s, thetas, 1)[0])
    offset = float(np.mean(thetas - rate * (times - at_s)))
    left = np.abs(thetas - offset - rate * (times - at_s))
    open_s = float(np.max(halves + left)) * 1e-9
    return Alignment(ECHO, offset, rate, first_ns + round(at_s), open_s)


def _passages(messages: Sequence[Wave], delays: Mapping[int, int]) -> Integers:
    """Return per echo the sender's clock of the echoed packet, and its passage by both clocks less
    its delay in the emulated link [ns] ``(packet, 2)``.
    """
    rows = [
        (
            int(m.echo_sent_ns),
            int(m.sent_ns) - int(m.echo_hold_ns) - int(m.echo_sent_ns) - delays.get(seq, 0),
        )
        for m in messages
        if (seq := int(m.echo_seq)) > 0
    ]
    return np.array(rows, dtype=np.int64).reshape(-1, 2)


def _within(passages: Integers, start: int, end: int) -> Integers:
    rows = (passages[:, 0] >= start) & (passages[:, 0] < end)
    return np.asarray(passages[rows, 1])


def _delays(fates: FateTraces | None) -> dict[int, int]:
    """Return the least delay of every packet that came out of a link, by its number [ns]."""
    if fates is None or len(np.unique(fates.epoch)) > 1:
        return {}
    out = fates.time_out_ns > 0
    found: dict[int, int] = {}
    took = (fates.time_out_ns - fates.time_in_ns)[out]
    for seq, delay in zip(fates.seq[out].tolist(), took.tolist(), strict=True):
        found[seq] = min(delay, found.get(seq, delay))
    return found
