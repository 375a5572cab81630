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
    whole = [rows.copy(), *(each.copy() for each in read)]
    filled = [np.any(each != 0.0, axis=0) for each in whole]  # entries other than zero in any run
    kept = list(range(n))
    while True:
        twins = _twins(whole[0], kept, always)
        for each, entries in zip(whole, filled, strict=True):
            for twin, first in twins.items():
                each[:, :, first] += each[:, :, twin]
                each[:, :, twin] = 0.0
                entries[:, [first, twin]] = np.any(each[:, :, [first, twin]] != 0.0, axis=0)
        still = [j for j in kept if j not in twins]
        moved = filled[0][still]  # (still, n and inputs)
        own = np.zeros_like(moved)
        own[np.arange(len(still)), still] = True
        columns = still + list(range(n, rows.shape[2]))
        driven = np.any((moved & ~own)[:, columns], axis=1)
        seen = np.any(np.concatenate([moved, *filled[1:]]), axis=0)
        left = [
            j
            for j, is_driven in zip(still, driven, strict=True)
            if always(j) or (is_driven and seen[j])
        ]
        gone = list(set(still) - set(left))
        for each, entries in zip(whole, filled, strict=True):
            each[:, :, gone] = 0.0
            entries[:, gone] = False
        if left == kept:
            break
        kept = left
    columns = kept + list(range(n, rows.shape[2]))
    found, *outputs = (each[:, :, columns] for each in whole)
    return Reduced(kept, found[:, kept], outputs)


def _twins(rows: Array, kept: list[int], always: Callable[[int], bool]) -> dict[int, int]:
    """Return states that are equal to an earlier one after every step."""
    first: dict[bytes, list[int]] = {}  # by their rows in the first run
    found = {}
    for j in kept:
        alike = first.setdefault((rows[0, j] + 0.0).tobytes(), [])
        earlier = next((i for i in alike if np.array_equal(rows[:, i], rows[:, j])), None)
        if earlier is None:
            alike.append(j)
        elif not always(j):
            found[j] = earlier
    return found
