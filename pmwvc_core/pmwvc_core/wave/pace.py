# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The clock of a playout: how fast it plays the sender's time, and how far beyond what has come.

Let e be the end of the newest segment and p the sender's time played. ``store_s`` is e - p: what
is in store, or, below zero, -c, the time that is concealed by a predicted wave. Per step h::

    p <- p + rate ratio h           never beyond e + HOLD_S + FADE_S
    rate  = 1 + shift/CORRECT_S     within 1 +- CORRECTED;   shift <- shift - (rate - 1) ratio h
    ratio = (HOLD_S + FADE_S - c)/FADE_S, within 0..1;   it rises by no more than h/RISE_S

So a wave without packets goes on for ``HOLD_S`` and then fades, since its time slows down; after
``REPORTED_S`` without a segment the other end is told, and after ``OUTAGE_S`` this one brakes.

The lag follows how late segments come. The first segment of a step, of length dt, shifts p by::

    shift <- shift - c dt/LATE_S    where it comes c too late
    shift <- shift + a dt/EARLY_S   where a was still in store

which settles where one in five comes late. What comes within ``BURST_S`` after an outage, a
standstill of this loop, or the beginning, says nothing of lateness; no more than a segment of it
is kept in store, and later no more than ``LONGEST_S``. The rest is skipped.

Nothing here depends on signals: one clock serves all axes, and all runs of a batch.

Equations: docs/theory.md 17.18.
"""

from pmwvc_core.state import Stateful

HOLD_S, FADE_S, RISE_S = 0.024, 0.03, 0.02
CORRECT_S, CORRECTED = 0.05, 0.3
LATE_S, EARLY_S = 0.2, 0.8
REPORTED_S, OUTAGE_S = 0.016, 0.04
BURST_S = 0.1
LONGEST_S = 0.3
ROUNDING_S = 1e-9


class Pace(Stateful):
    """See the module.

    Attributes
    ----------
    store_s
        Time in store; below zero: concealed [s].
    shift_s
        By which the lag is still to become shorter; below zero longer [s].
    silent_s
        Time without a segment since there was none in store any more, by this end's clock [s].
    """

    MEMORY = "store_s silent_s shift_s _ratio _burst_s _segment_s _first"

    def __init__(self) -> None:
        self.store_s = self.silent_s = self.shift_s = 0.0
        self._ratio = 1.0
        self._burst_s = BURST_S
        self._segment_s = 0.0  # length of the newest segment
        self._first = True  # none has come since the last step

    @property
    def waits(self) -> bool:
        """Whether nothing has come for so long that the other end is told."""
        return self.silent_s > REPORTED_S

    @property
    def brakes(self) -> bool:
        """Whether the wave has been predicted for so long that this end brakes."""
        return self.silent_s > OUTAGE_S

    def arrive(self, lasted_s: float) -> None:
        """Note a segment that stands for so long [s]."""
        if self.silent_s > OUTAGE_S:
            self._burst_s = BURST_S
        else:
            self._segment_s = lasted_s
        if self._first and self._burst_s <= 0.0:
            slow_s = LATE_S if self.store_s < 0.0 else EARLY_S
            self.shift_s += self.store_s * min(lasted_s / slow_s, 1.0)
        self._first = False
        self.store_s += lasted_s
        self.silent_s = 0.0

    def pass_by(self, lasted_s: float) -> None:
        """Let time go by in which the loop did not run [s]: what is in store is skipped."""
        self.store_s -= max(min(lasted_s, self.store_s), 0.0)
        if lasted_s > OUTAGE_S:
            self._burst_s = BURST_S

    def step(self, h: float) -> tuple[float, float]:
        """Go on by ``h``; return how much of the store is skipped before, and how much is played
        beyond what has come [s].
        """
        longest_s = self._segment_s if self._burst_s > 0.0 else LONGEST_S
        self._burst_s = max(self._burst_s - h, 0.0)
        skipped_s = max(self.store_s - h - longest_s, 0.0)
        self.store_s -= skipped_s
        in_store_s, left_s = max(self.store_s, 0.0), self.store_s + HOLD_S + FADE_S
        self._ratio = max(min(left_s / FADE_S, 1.0, self._ratio + h / RISE_S), 0.0)
        excess = max(min(self.shift_s / CORRECT_S, CORRECTED), -CORRECTED)
        self.shift_s -= excess * self._ratio * h
        time_s = min((1.0 + excess) * self._ratio * h, left_s)
        self.store_s -= time_s
        if abs(self.store_s) < ROUNDING_S:
            self.store_s = 0.0
        if self.store_s < 0.0:
            self.silent_s += max(h - in_store_s, 0.0)
        self._first = True
        return skipped_s, max(time_s - in_store_s, 0.0) if self.store_s < 0.0 else 0.0
