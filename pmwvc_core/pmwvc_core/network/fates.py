# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of what became of packets, collected for publishing in blocks."""

from typing import Any

import numpy as np

from pmwvc_core.network.in_flight import Fate

COLUMNS = {  # of a record, by the names of the PacketFate message
    **{"epoch": np.uint64, "seq": np.uint32, "bytes": np.uint32},
    **dict.fromkeys(("time_in_ns", "time_due_ns", "time_out_ns"), np.int64),
    **{"fate": np.uint8, "cause": np.uint8},
}


class FateLog:
    """Collect the fates of one link, each once it is final.

    A packet that never comes out is final when the link decides so; any other when it has left.
    """

    def __init__(self) -> None:
        self._records: list[tuple[int, ...]] = []
        self._taken = 0

    def __len__(self) -> int:
        """Return how many records wait to be taken."""
        return len(self._records)

    def add(
        self, fate: Fate, *, time_out_ns: int = 0, epoch: int = 0, seq: int | None = None
    ) -> None:
        """Note a final fate, with the time at which the packet really left (0: never), and epoch
        and seq of the sender; where these are not known 0 and the link's own count.
        """
        packet = (epoch, fate.number if seq is None else seq, fate.size)
        times_ns = (fate.time_in_ns, fate.time_due_ns, time_out_ns)
        self._records.append((*packet, *times_ns, fate.kind, fate.cause))

    def take(self, most: int | None = None) -> dict[str, Any]:
        """Return the oldest records, at most ``most``, as columns by name, and forget them;
        ``first`` is the number of the first one: 1, 2, 3...
        """
        records = self._records[:most]
        self._records = self._records[len(records) :]
        first = self._taken + 1
        self._taken += len(records)
        columns = list(zip(*records, strict=True)) or [()] * len(COLUMNS)
        named = zip(COLUMNS.items(), columns, strict=True)
        return {"first": first} | {n: np.array(each, dtype=kind) for (n, kind), each in named}
