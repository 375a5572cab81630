# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets in flight in one direction: their fates, the record of these, and when and in which
order packets come out. Times are integer nanoseconds of one clock.

What decides on a fate is :mod:`pmwvc_core.network.link`, or here a recording.
"""

import enum
import heapq
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.plugins import Faults


class FateKind(enum.IntEnum):
    """Kinds of fate of a packet; the numbers are those of the PacketFate message."""

    DELIVERED = 0
    LOST = 1
    DUPLICATE = 2  # an extra copy
    DROPPED_RATE = 3
    DROPPED_QUEUE = 4
    INVALID = 5


class Cause(enum.IntEnum):
    """Causes of a fate; the numbers are those of the PacketFate message."""

    NONE = 0
    LOSS = 1
    RATE_LIMIT = 2
    QUEUE_FULL = 3
    DUPLICATION = 4
    OUTAGE = 5
    CORRUPTION = 6  # comes out with a bit flipped


@dataclass(slots=True)
class Fate:
    """The decision of the link for one packet or copy."""

    number: int  # of the packet on this link: 1, 2, 3...; a copy has its original's
    time_in_ns: int = 0
    time_due_ns: int = 0  # 0: never
    kind: FateKind = FateKind.DELIVERED
    cause: Cause = Cause.NONE
    size: int = 0  # [byte]
    copy: int = 0  # 0: the packet itself; 1, 2...: an extra copy of it
    flip: float = 0.0  # corrupted: where in the packet the flipped bit is, [0, 1)


@dataclass(slots=True)
class LinkCounters:
    """Counts since the start."""

    in_count: int = 0
    out_count: int = 0  # with copies
    lost: int = 0
    dropped: int = 0
    queued: int = 0  # inside the link now


DELIVERED = FateKind.DELIVERED  # an attribute of an enum is slow to look up
TRAVELLING = (DELIVERED, FateKind.DUPLICATE)  # until they come out


class InFlight:
    """The packets that went in and have not come out yet, with the counters of a link."""

    def __init__(self) -> None:
        self.counters = LinkCounters()
        self.faults = Faults("link.effects")
        self._in_flight: list[tuple[int, int, Any, Fate]] = []  # heap: due, order, payload, fate
        self._entered = 0

    @property
    def next_due_ns(self) -> int | None:
        """Time at which the next packet comes out [ns]; None when none is in flight."""
        return self._in_flight[0][0] if self._in_flight else None

    @property
    def failed(self) -> str:
        """How often plug-ins failed, and how they did last; empty where they did not."""
        steps, text = self.faults.steps, self.faults.text
        return f"calls without the effect: {steps}; last: {text}" if steps else ""

    def arrivals(self, now_ns: int) -> list[tuple[Any, Fate]]:
        """Take out what is due by now, in the order of delivery."""
        out = []
        waiting = self._in_flight
        while waiting and waiting[0][0] <= now_ns:
            _, _, payload, fate = heapq.heappop(waiting)
            out.append((payload, fate))
        self.counters.out_count += len(out)
        self.counters.queued = len(waiting)
        return out

    def _enter(self, payload: Any, fate: Fate, due_ns: int) -> None:
        """Send a packet or copy on its way; what is due at one time comes out as it went in."""
        fate.time_due_ns = due_ns
        self._entered += 1
        heapq.heappush(self._in_flight, (due_ns, self._entered, payload, fate))
        self.counters.queued = len(self._in_flight)


class RecordedFate(NamedTuple):
    """The recorded fate of a packet or of its copy."""

    delay_ns: int | None  # from its sending to its coming out; None: never
    kind: FateKind = FateKind.DELIVERED
    cause: Cause = Cause.NONE
    at_ns: int | None = None  # when it came out, where that is to be kept


LOST_RECORD = (RecordedFate(None, FateKind.LOST, Cause.LOSS),)


class RecordedLink(InFlight):
    """A link that does to its packets what was recorded of another: for replays.

    ``record`` holds for every packet number (1, 2, 3...) its fate, followed by those of its
    copies. What the recording does not reach is lost.
    """

    def __init__(self, record: Mapping[int, Sequence[RecordedFate]]) -> None:
        super().__init__()
        self._record = record

    def send(self, payload: Any, now_ns: int, *, size_bytes: int = 140) -> list[Fate]:
        """As :meth:`pmwvc_core.network.link.Link.send`."""
        counters = self.counters
        counters.in_count = number = counters.in_count + 1
        fates = []
        for delay_ns, kind, cause, at_ns in self._record.get(number, LOST_RECORD):
            fate = Fate(number, now_ns, 0, kind, cause, size_bytes)
            fates.append(fate)
            counters.lost += kind is FateKind.LOST
            counters.dropped += kind not in (*TRAVELLING, FateKind.LOST)
            if delay_ns is not None and kind in TRAVELLING:
                due_ns = now_ns + delay_ns if at_ns is None else at_ns
                self._enter(payload, fate, max(due_ns, now_ns))
        return fates


COLUMNS = {  # of a record, by the names of the PacketFate message
    **{"epoch": np.uint64, "seq": np.uint32, "bytes": np.uint32},
    **dict.fromkeys(("time_in_ns", "time_due_ns", "time_out_ns"), np.int64),
    **{"fate": np.uint8, "cause": np.uint8},
}


class FateLog:
    """Collect the fates of one link for publishing in blocks, each once it is final."""

    def __init__(self) -> None:
        self._records: list[tuple[int, ...]] = []
        self._taken = 0

    def __len__(self) -> int:
        return len(self._records)

    def add(
        self, fate: Fate, *, time_out_ns: int = 0, epoch: int = 0, seq: int | None = None
    ) -> None:
        """Note a final fate, its time of leaving (0: never), and its sender's numbers."""
        number, times_ns = fate.number if seq is None else seq, (fate.time_in_ns, fate.time_due_ns)
        row = (epoch, number, fate.size, *times_ns, time_out_ns, fate.kind, fate.cause)
        self._records.append(row)

    def take(self, most: int | None = None) -> dict[str, Any]:
        """Return the oldest records as columns, and the number of the ``first``."""
        records = np.array(self._records[:most], dtype=list(COLUMNS.items()))
        self._records = self._records[len(records) :]
        self._taken += len(records)
        first = self._taken - len(records) + 1
        return {"first": first} | {name: records[name].copy() for name in COLUMNS}
