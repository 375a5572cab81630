# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The margin of a playout: the time kept at hand against waits, and the rate that keeps it.

A segment that arrives while s is at hand has used margin - s of the margin. That is missing, and
is made up by playing slower, with the time constant ``REFILL_S``, never below ``LEAST_RATE``::

    missing <- max(margin - s, 0)  where a segment arrives; the whole margin after a wait
    rate     = max(1 - missing/REFILL_S, LEAST_RATE),   missing <- missing - (1 - rate) h

Where nothing is at hand the playout waits; the ends brake once that takes ``BRAKED_S``. A hand
gains speed in a wait, and the damper's force adds to the wave that returns. So the wave returns
slowly, whatever arrives meanwhile::

    restart <- min(wait, RESTART_S)   after a wait
    rate     = 1 - restart/REFILL_S   where that is less,   restart <- restart - (1 - rate) h

A segment that ends a wait came later than the margin allowed for: by the wait and what was left of
the margin when it began. Two such make a margin of the less late one. The margin fades over
``FADE_S``, to no less than was used of it in the last ``WINDOW_S``.

Where for ``WINDOW_S`` at least e more than the margin was at hand, the rate is 1 + e/CATCH_UP_S,
by ``SLIGHTLY`` to ``FASTEST`` above 1. That costs energy, which the playout has or has not. A wait
longer than ``LONGEST_WAIT_S`` is an outage, no jitter.

Equations: docs/theory.md 17.18.
"""

import math

from pmwvc_core.numeric import Flag, Value, anywhere, maximum, minimum, where
from pmwvc_core.state import Stateful

REFILL_S = 0.02
LEAST_RATE = 0.7
SLIGHTLY, FASTEST = 0.05, 0.3  # of the rate beyond 1 while it catches up
CATCH_UP_S = 1.0
WINDOW_S = 3.0  # the least at hand in one or two of these decides whether to catch up
FADE_S = 5.0
KEPT = math.exp(-WINDOW_S / FADE_S)  # of the margin after a window
SLACK_S = 1.5e-3  # at hand beyond the margin: no reason to catch up
LONGEST_WAIT_S = 0.04
RESTART_S = 0.01  # longest lag that a slow return of the wave adds
SHORTEST_WAIT_S = 1e-5  # less is no wait: the refill never ends
BRAKED_S = 4.5e-3  # shorter waits move nobody: a brake would be felt more


class Margin(Stateful):
    """See the module. Floats for one run, else arrays ``(..., 1)``.

    Attributes
    ----------
    time_s
        The margin [s].
    excess_s
        What was at hand beyond it for long; zero or less: nothing to catch up [s].
    waits
        Whether nothing has been at hand for so long that the ends brake.
    """

    MEMORY = (
        "time_s excess_s waits _missing_s _restart_s _wait_s _had_s _latest_s _used_s _least_s "
        "_least_before_s _window_s _step_s"
    )

    def __init__(self) -> None:
        self.time_s: Value = 0.0
        self.excess_s: Value = 0.0
        self.waits: Flag = False
        self._missing_s: Value = 0.0  # of the margin
        self._restart_s: Value = 0.0  # lag that the slow return still adds
        self._wait_s: Value = 0.0  # the wait under way
        self._had_s: Value = 0.0  # of the margin, when it began
        self._latest_s: Value = 0.0  # by how much a segment came late at most, of late
        self._used_s: Value = 0.0  # of the margin, in this window
        self._least_s: Value = math.inf  # at hand, in this window and in the last one
        self._least_before_s: Value = math.inf
        self._window_s = 0.0
        self._step_s = 0.0

    def disable(self) -> None:
        """Let the next step keep no margin, add no lag behind a wait, and catch nothing up."""
        self.time_s = self._latest_s = self._used_s = self._missing_s = 0.0
        self._restart_s = self._wait_s = 0.0
        self.waits, self._least_before_s = False, -math.inf

    def arrive(self, at_hand_s: Value) -> None:
        """Note that a segment arrives while so much is at hand [s]."""
        self._missing_s = maximum(self.time_s - at_hand_s, 0.0)
        self._used_s = maximum(self._used_s, self._missing_s)

    def watch(self, spare_s: Value, h: float) -> Flag:
        """Learn from a step of ``h`` seconds after which ``spare_s`` will be at hand (below zero:
        a wait); tell whether an outage ends here.
        """
        if h < self._step_s:  # what was at hand behind longer steps tells nothing
            self._least_before_s, self._least_s, self._window_s = -math.inf, math.inf, 0.0
        self._step_s = h
        self._window_s += h
        if self._window_s > WINDOW_S:
            self._window_s = 0.0
            self._least_before_s, self._least_s = self._least_s, math.inf
            self.time_s = maximum(KEPT * self.time_s, self._used_s)
            self._latest_s = maximum(KEPT * self._latest_s, self._used_s)
            self._used_s = 0.0
        self._least_s = minimum(self._least_s, spare_s)
        self.excess_s = minimum(self._least_s, self._least_before_s) - self.time_s - SLACK_S
        dry = spare_s < -SHORTEST_WAIT_S
        over = (self._wait_s > 0.0) & (dry ^ True)
        outage: Flag = False
        if over is not False and anywhere(over):
            outage = over & (self._wait_s > LONGEST_WAIT_S)
            self._learn(over, outage)
        if dry is not False and anywhere(dry):
            begins = dry & (self._wait_s <= 0.0)
            had_s = maximum(self.time_s - self._missing_s, 0.0)
            self._had_s = where(begins, had_s, self._had_s)
            self._wait_s = self._wait_s + where(dry, minimum(-spare_s, h), 0.0)
            self.waits = self._wait_s > BRAKED_S
        return outage

    def _learn(self, over: Flag, outage: Flag) -> None:
        """Take the wait that is over into account."""
        wait_s, counts = self._wait_s, over & (outage ^ True)
        late_s = wait_s + self._had_s
        again_s = maximum(self.time_s, minimum(late_s, self._latest_s))
        self.time_s = where(counts, again_s, self.time_s)
        self._latest_s = where(counts, maximum(self._latest_s, late_s), self._latest_s)
        self._used_s = where(counts, self.time_s, self._used_s)
        self._missing_s = where(over, self.time_s, self._missing_s)
        self._restart_s = where(over, minimum(wait_s, RESTART_S), self._restart_s)
        self._wait_s = where(over, 0.0, wait_s)
        self.waits = self._wait_s > BRAKED_S

    def rate(self, h: float) -> Value:
        """Return how fast the sender's time is played in a step of ``h`` seconds: never faster
        than it went by.
        """
        missing_s, restart_s = self._missing_s, self._restart_s
        slow = missing_s + restart_s > 0.0
        if slow is False or not anywhere(slow):
            return 1.0
        per_s = 1.0 / max(REFILL_S, h)
        slower = maximum(minimum(missing_s * per_s, 1.0 - LEAST_RATE), restart_s * per_s)
        self._missing_s = maximum(missing_s - slower * h, 0.0)
        left_s = maximum(restart_s - slower * h, 0.0)
        self._restart_s = where(left_s > SHORTEST_WAIT_S, left_s, 0.0)
        return 1.0 - slower

    @property
    def faster(self) -> Value:
        """The rate that catches up, where there is an excess and energy can be spared."""
        excess = self.excess_s * (1.0 / CATCH_UP_S)
        return 1.0 + maximum(minimum(excess, FASTEST), SLIGHTLY)
