# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Timekeeping of a loop: counts that the loop writes and a second thread reads."""


class Health:
    """Ticks, lateness and computing time since the reader last looked.

    The reader puts a fresh object into the loop and keeps the old one, so the loop never waits and
    no lock is needed. Nothing here is allocated per tick.
    """

    __slots__ = ("compute_max_ns", "compute_sum_ns", "late_max_ns", "late_sum_ns", "ticks")

    def __init__(self) -> None:
        self.ticks = 0
        self.late_sum_ns = 0
        self.late_max_ns = 0
        self.compute_sum_ns = 0
        self.compute_max_ns = 0

    def add(self, late_ns: int, compute_ns: int) -> None:
        """Count one tick."""
        self.ticks += 1
        self.late_sum_ns += late_ns
        self.compute_sum_ns += compute_ns
        if late_ns > self.late_max_ns:
            self.late_max_ns = late_ns
        if compute_ns > self.compute_max_ns:
            self.compute_max_ns = compute_ns

    def values(self, elapsed_s: float) -> dict[str, float]:
        """Return rate [Hz], and means and maxima [us], by name."""
        ticks = max(self.ticks, 1)
        return {
            "rate [Hz]": self.ticks / elapsed_s,
            "lateness mean [us]": self.late_sum_ns / ticks / 1e3,
            "lateness max [us]": self.late_max_ns / 1e3,
            "compute mean [us]": self.compute_sum_ns / ticks / 1e3,
            "compute max [us]": self.compute_max_ns / 1e3,
        }
