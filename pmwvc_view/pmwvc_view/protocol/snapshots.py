# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Snapshots of a session, and those that a page has not been sent yet, as one.

A page that is slow is sent the present, with the extremes and packets of all that it missed. Pages
that are not share the message of a snapshot.
"""

from collections import deque
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_view.protocol import CREDITS
from pmwvc_view.protocol.snapshot import Layout

MOST_PACKETS = 512  # of a snapshot; the oldest are left out


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The session at one time: a row of its layout, and packets ``(n, 5)``."""

    row: Array
    packets: Array

    @cached_property
    def message(self) -> bytes:
        """The snapshot as pages get it: the row, then the packets, float64, little-endian."""
        every = np.concatenate([self.row, self.packets.ravel()])
        return every.astype("<f8", copy=False).tobytes()


class Outgoing:
    """The snapshots for one page: merged until it may be sent one."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._low = layout.positions("f_min")
        self._high = layout.positions("f_max", "lateness")
        self._waiting: Snapshot | None = None
        self._unseen: deque[int] = deque()

    def add(self, snapshot: Snapshot) -> None:
        """Take a snapshot in; numbers are those of the newest, extremes those of all."""
        before = self._waiting
        if before is not None:
            row = snapshot.row.copy()
            row[self._low] = np.fmin(row[self._low], before.row[self._low])
            row[self._high] = np.fmax(row[self._high], before.row[self._high])
            packets = np.concatenate([before.packets, snapshot.packets])[-MOST_PACKETS:]
            snapshot = Snapshot(row, packets)
        self._waiting = snapshot

    def take(self) -> bytes | None:
        """Return the message to send now; None where nothing waits or the page is behind."""
        if self._waiting is None or len(self._unseen) >= CREDITS:
            return None
        snapshot, self._waiting = self._waiting, None
        self._unseen.append(int(snapshot.row[0]))
        return snapshot.message

    def seen(self, seq: int) -> None:
        """Note that the page has taken in every snapshot up to this number."""
        while self._unseen and self._unseen[0] <= seq:
            self._unseen.popleft()
