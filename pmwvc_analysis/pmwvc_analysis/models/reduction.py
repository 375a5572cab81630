# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The reduced state: states that are not read, not driven, or present twice are left out.

None of that changes an eigenvalue other than zero, nor what follows from the inputs. Structure
counts, not size: a state is left out where its entries are exactly zero, or two rows exactly
equal, in every run.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array


class Reduced(NamedTuple):
    """States that are kept, and the matrices on them."""

    kept: list[int]
    rows: Array  # (runs, kept, kept and inputs)
    read: list[Array]  # (runs, signals, kept and inputs)


def reduced(rows: Array, read: Sequence[Array], *, always: Callable[[int], bool]) -> Reduced:
    """Leave out states that do not matter.

    Parameters
    ----------
    rows
        ``(runs, n, n and inputs)``: the states after a step.
    read
        ``(runs, signals, n and inputs)``: what is read of them otherwise.
    """
    n = rows.shape[1]
    rows, read = rows.copy(), [each.copy() for each in read]
    kept = list(range(n))
    while True:
        twins = _twins(rows, kept, always)
        for twin, first in twins.items():
            for each in (rows, *read):
                each[:, :, first] += each[:, :, twin]
                each[:, :, twin] = 0.0
        still = [j for j in kept if j not in twins]
        moved = np.any(rows[:, still] != 0.0, axis=0)  # (still, n and inputs)
        own = np.zeros_like(moved)
        own[np.arange(len(still)), still] = True
        columns = still + list(range(n, rows.shape[2]))
        driven = np.any((moved & ~own)[:, columns], axis=1)
        seen = np.any(moved, axis=0)
        for each in read:
            seen = seen | np.any(each != 0.0, axis=(0, 1))
        left = [
            j
            for j, is_driven in zip(still, driven, strict=True)
            if always(j) or (is_driven and seen[j])
        ]
        for j in set(still) - set(left):
            for each in (rows, *read):
                each[:, :, j] = 0.0
        if left == kept:
            break
        kept = left
    columns = kept + list(range(n, rows.shape[2]))
    return Reduced(kept, rows[:, kept][:, :, columns], [each[:, :, columns] for each in read])


def _twins(rows: Array, kept: list[int], always: Callable[[int], bool]) -> dict[int, int]:
    """Return states that are equal to an earlier one after every step."""
    first: dict[bytes, int] = {}
    found = {}
    for j in kept:
        earlier = first.setdefault((rows[:, j] + 0.0).tobytes(), j)
        if earlier != j and not always(j):
            found[j] = earlier
    return found
