# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The largest force of a brake that holds on while no waves come.

It is ``RATIO`` times the force that the end rendered before, which is its mean over ``MEAN_S``: a
hand or an object that presses a little harder than then is held, and nothing is held that moved
freely. It grows over ``RISE_S``, or a wait of one packet would stop a moving object dead, stays
while the end waits, and fades over ``return_s`` once waves are back. A wait that begins before it
has faded takes it up from there; what is rendered meanwhile counts for nothing, or every wait
would raise it.

Equations: docs/theory.md 17.15.
"""

from pmwvc_core.numeric import Flag, Value, maximum, minimum, root, squared, truth, where
from pmwvc_core.state import Stateful

RATIO = 1.3
MEAN_S = 0.05
RISE_S = 0.04


class BrakeForce(Stateful):
    """See the module.

    Parameters
    ----------
    step_s
        Time of a step [s].
    return_s
        Time in which the brake lets go when waves are back [s].

    Attributes
    ----------
    limit
        Largest force of the present step [N], one per run; zero where nothing is held.
    idle
        Whether no run brakes.
    """

    MEMORY = "limit idle _mean _held _left"

    def __init__(self, *, step_s: float, return_s: float) -> None:
        self._return_s = return_s
        self.last(step_s)
        self.reset()

    def last(self, step_s: float) -> None:
        """Take steps of another length over [s]."""
        self._weight = min(step_s / MEAN_S, 1.0)
        self._rise = step_s / RISE_S
        self._fall = step_s / self._return_s

    def reset(self) -> None:
        """Begin with an end that renders no force."""
        self.limit: Value = 0.0
        self.idle = True
        self._mean: Value = 0.0  # force rendered [N]
        self._held: Value = 0.0  # largest force in a wait [N]
        self._left: Value = 0.0  # ratio of it that acts

    def step(self, waits: Flag, f: Value) -> None:
        """Go one step on.

        Parameters
        ----------
        waits
            Whether no waves come, at this end or at the other one.
        f
            Force rendered in the last step [N], ``(..., dof)``.
        """
        if self.idle:
            self._mean = self._mean + self._weight * (f - self._mean)
            if waits is False or not _anywhere(waits):
                return
            self._held = RATIO * root(squared(self._mean))
        else:
            free = self._left <= 0.0
            mean = self._mean + self._weight * (f - self._mean)
            self._mean = where(free, mean, self._mean)
            self._held = where(free, RATIO * root(squared(self._mean)), self._held)
        change = where(waits, self._rise, -self._fall)
        self._left = minimum(maximum(self._left + change, 0.0), 1.0)
        self.limit = self._held * self._left
        self.idle = truth(self._left <= 0.0)


def _anywhere(waits: Flag) -> bool:
    return not truth(waits ^ True)
