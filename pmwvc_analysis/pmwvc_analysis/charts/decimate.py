# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Fewer points of a curve with the same picture: per column the first, the lowest, the highest
and the last point are kept, so that no peak is lost.
"""

import numpy as np

from pmwvc_core.numeric import Array, Integers


def segments(x: Array, y: Array, *, longest_step: float) -> list[Integers]:
    """Return the indices of each stretch without NaN or a longer step (0: of any length)."""
    rows = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if not len(rows):
        return []
    breaks = np.diff(rows) > 1
    if longest_step > 0.0:
        breaks |= np.diff(x[rows]) > longest_step
    return np.split(rows, np.flatnonzero(breaks) + 1)


def envelope(x: Array, y: Array, rows: Integers, *, column: float) -> Integers:
    """Return which of ``rows`` to draw where a column of the picture is ``column`` wide."""
    if len(rows) <= 4 or column <= 0.0:
        return rows
    columns = np.floor((x[rows] - x[rows[0]]) / column)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(columns)) + 1])
    if len(starts) > len(rows) / 4:
        return rows
    ends = np.concatenate([starts[1:], [len(rows)]])
    kept = [starts, ends - 1]
    values = y[rows]
    for extreme in (np.argmin, np.argmax):
        pairs = zip(starts, ends, strict=True)
        kept.append(np.array([start + extreme(values[start:end]) for start, end in pairs]))
    return np.asarray(rows[np.unique(np.concatenate(kept))])


def reduced(x: Array, y: Array, *, period: float, column: float) -> list[Integers]:
    """Return the indices of each stretch to draw; a gap narrower than a column is none."""
    step = max(1.5 * period, column) if period > 0.0 else 0.0
    return [envelope(x, y, part, column=column) for part in segments(x, y, longest_step=step)]
