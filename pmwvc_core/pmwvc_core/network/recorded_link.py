# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A link that does to its packets what was recorded of another: for replays.

Packet number n of the replay is lost, delayed or copied as number n of the recording was. Where
the replay sends more or fewer packets in the same time (another rate drop), its packet number n
meets the fate of the one that was recorded at that time. What the recording does not reach is
lost. Times are integer nanoseconds.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from pmwvc_core.network.in_flight import DELIVERED, TRAVELLING, Cause, Fate, FateKind, InFlight


class RecordedFate(NamedTuple):
    """The recorded fate of a packet or of its copy.

    ``delay_ns`` is the time from its sending to its coming out; None: it never came out.
    ``at_ns`` is the instant at which it came out, where that is to be kept.
    """

    delay_ns: int | None
    kind: FateKind = FateKind.DELIVERED
    cause: Cause = Cause.NONE
    at_ns: int | None = None


COUNTERS = {FateKind.LOST: "lost", FateKind.DUPLICATE: "duplicated"}
LOST_RECORD = (RecordedFate(None, FateKind.LOST, Cause.LOSS),)


class RecordedLink(InFlight):
    """See the module; ``send`` is that of :class:`pmwvc_core.network.Link`.

    ``record`` holds for every packet number (1, 2, 3...) its fate, followed by those of its
    copies; ``per_packet`` are recorded packets per packet sent here, 1 unless the rate is another.
    """

    def __init__(
        self, record: Mapping[int, Sequence[RecordedFate]], *, per_packet: float = 1.0
    ) -> None:
        super().__init__()
        self._record = record
        self._per_packet = per_packet

    def send(self, payload: Any, now_ns: int, *, size_bytes: int = 140) -> list[Fate]:
        """Put a packet in; return its fate, and one for every extra copy."""
        counters = self.counters
        counters.in_count = number = counters.in_count + 1
        recorded = self._record.get(1 + int((number - 1) * self._per_packet + 1e-9), LOST_RECORD)
        return [self._travel(payload, number, now_ns, size_bytes, each) for each in recorded]

    def _travel(
        self, payload: Any, number: int, now_ns: int, size: int, recorded: RecordedFate
    ) -> Fate:
        delay_ns, kind, cause, at_ns = recorded
        fate = Fate(number, now_ns, 0, kind, cause, size)
        if kind is not DELIVERED:
            counter = COUNTERS.get(kind, "dropped")
            setattr(self.counters, counter, getattr(self.counters, counter) + 1)
        if cause is Cause.CORRUPTION:
            self.counters.corrupted += 1
        if delay_ns is not None and kind in TRAVELLING:
            due_ns = now_ns + delay_ns if at_ns is None else at_ns
            self._enter(payload, fate, max(due_ns, now_ns))
        return fate
