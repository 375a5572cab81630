# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One event of a session, and stretches of time with a flag set."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array

Event = dict[str, Any]


def event(time_s: float | None, who: str, kind: str, what: str) -> Event:
    """Return an event; kinds: :mod:`.events`."""
    return {
        "time_s": None if time_s is None else round(float(time_s), 6),
        "who": who,
        "kind": kind,
        "what": what,
    }


def runs(flags: NDArray[np.bool_], time_s: Array, *, join_s: float) -> list[tuple[int, int]]:
    """Return first and last row of every stretch with a flag set; close ones are one."""
    rows = np.flatnonzero(flags)
    if not len(rows):
        return []
    breaks = np.flatnonzero(np.diff(time_s[rows]) > join_s)
    firsts = rows[np.concatenate([[0], breaks + 1])]
    lasts = rows[np.concatenate([breaks, [len(rows) - 1]])]
    return [(int(first), int(last)) for first, last in zip(firsts, lasts, strict=True)]


def changes(values: NDArray[Any]) -> list[int]:
    """Return the rows at which a value differs from the one before."""
    return [int(row) + 1 for row in np.flatnonzero(values[1:] != values[:-1])]
