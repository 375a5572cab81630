# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The states of a linear system that matter: those that are read and driven, present twice once.

Entries are exactly zero or rows exactly equal in every run: leaving such states out changes no
eigenvalue other than zero, nor what follows from the inputs.
"""

from collections.abc import Iterable

import numpy as np

from pmwvc_analysis.models.response import MOVING, StateName
from pmwvc_core.numeric import Array, Flags, Integers

PLACED = (*MOVING, ".deflection", ".local.x")  # and of springs: what gives a rigid motion


def placed(states: Iterable[StateName]) -> Flags:
    """Tell of every state whether it is one that gives a rigid motion ``(n,)``."""
    return np.array([name.endswith(PLACED) for name, _ in states], dtype=np.bool_)


def reduced(whole: Array, always: Flags) -> tuple[list[int], Array]:
    """Return the states that matter, and the matrix on them alone.

    ``whole`` is ``(runs, n and signals, n and inputs)``: the n states after a step, and what is
    read of them otherwise; ``always`` are ``(n,)`` states that matter in any case.
    """
    n, whole = len(always), whole.copy()
    filled = np.any(whole != 0.0, axis=0)  # entries other than zero in any run
    kept = np.arange(n)
    while True:
        twins = _twins(whole, kept, always)
        for twin, first in twins.items():
            whole[:, :, first] += whole[:, :, twin]
            filled[:, first] = np.any(whole[:, :, first] != 0.0, axis=0)
        still = np.setdiff1d(kept, list(twins))
        own = still[:, np.newaxis] == np.arange(whole.shape[2])
        columns = np.r_[still, n : whole.shape[2]]
        driven = np.any((filled[still] & ~own)[:, columns], axis=1)
        others = filled[still] & ~(own & (whole[0, still] == 1.0))  # a sum only it reads is none
        seen = others.any(axis=0) | filled[n:].any(axis=0)
        left = still[always[still] | (driven & seen[still])]
        gone = np.setdiff1d(kept, left)
        whole[:, :, gone], filled[:, gone] = 0.0, False
        if len(left) == len(kept):
            rows = np.r_[kept, n : whole.shape[1]]
            return kept.tolist(), whole[:, rows[:, np.newaxis], np.r_[kept, n : whole.shape[2]]]
        kept = left


def _twins(whole: Array, kept: Integers, always: Flags) -> dict[int, int]:
    """Return states that are equal to an earlier one after every step."""
    first: dict[bytes, int] = {}  # by their rows in every run
    return {
        j: earlier
        for j in kept.tolist()
        if (earlier := first.setdefault((whole[:, j] + 0.0).tobytes(), j)) != j and not always[j]
    }
