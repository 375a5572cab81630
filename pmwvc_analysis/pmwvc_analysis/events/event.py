# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One event of a session."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Event = dict[str, Any]


def event(time_s: float | None, who: str, kind: str, what: str) -> Event:
    """Return an event; kinds: :mod:`.events`."""
    return {
        "time_s": None if time_s is None else round(float(time_s), 6),
        "who": who,
        "kind": kind,
        "what": what,
    }


def changes(values: NDArray[Any]) -> list[int]:
    """Return the rows at which a value differs from the one before."""
    return [int(row) + 1 for row in np.flatnonzero(values[1:] != values[:-1])]
