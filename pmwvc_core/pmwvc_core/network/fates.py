# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of what became of packets, collected for publishing in blocks."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.network.in_flight import Fate


@dataclass(frozen=True)
class FateBlock:
    """Records as columns, by the names of the PacketFate message."""

    first: int  # number of the first record: 1, 2, 3...
    epoch: NDArray[np.uint64]
    seq: NDArray[np.uint32]
    bytes: NDArray[np.uint32]
    time_in_ns: NDArray[np.int64]
    time_due_ns: NDArray[np.int64]
    time_out_ns: NDArray[np.int64]
    fate: NDArray[np.uint8]
    cause: NDArray[np.uint8]


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
        """Note a final fate.

        Parameters
        ----------
        time_out_ns
            When the packet really left; 0: never.
        epoch, seq
            Of the sender where known, else 0 and the link's own count.
        """
        self._records.append(
            (
                epoch,
                fate.number if seq is None else seq,
                fate.size,
                fate.time_in_ns,
                fate.time_due_ns,
                time_out_ns,
                fate.kind,
                fate.cause,
            )
        )

    def take(self, most: int | None = None) -> FateBlock:
        """Return the oldest records, at most ``most``, and forget them."""
        records = self._records[:most]
        self._records = self._records[len(records) :]
        columns = list(zip(*records, strict=True)) or [()] * 8
        types = (np.uint64, np.uint32, np.uint32, np.int64, np.int64, np.int64, np.uint8, np.uint8)
        arrays = [np.array(c, dtype=t) for c, t in zip(columns, types, strict=True)]
        first = self._taken + 1
        self._taken += len(records)
        return FateBlock(first, *arrays)
