# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The compensation as published (App. C Eq. 14, 15), for comparison only: it injects energy.

::

    dE(n) = dE(n-1) + T [F(n) F(n-1) - F(n)^2]/b        of each user, from the start [J]
    v     = sgn(v) sqrt(v^2 - 2 dE(n))                  where dE(n) < 0

dE is never above zero for long, so the wave is made longer, by energy (J) taken for power (W), at
every step for all that ever happened. Several axes: the wave keeps its direction.

Equations: docs/theory.md 5.6.
"""

from collections.abc import Mapping, Sequence

from pmwvc_core.numeric import Value, minimum, root, squared, where
from pmwvc_core.server.compensations.record import Compensation, Wave
from pmwvc_core.state import Stateful


class AsPublished(Stateful):
    """Eq. 15 to the letter."""

    MEMORY = "_delay"
    accounts: Mapping[str, Value] = {}

    def __init__(self, users: int, *, period: float) -> None:
        self._period = period
        self._delay: list[Value] = [0.0] * users  # [J]

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return the waves made longer."""
        return [self._changed(wave) for wave in waves]

    def _changed(self, wave: Wave) -> Value:
        delay = self._delay[wave.user] = self._delay[wave.user] + self._period * wave.late
        return stretched(wave.v, squared(wave.v) - 2.0 * minimum(delay, 0.0))


def stretched(v: Value, square: Value) -> Value:
    """Return ``v`` with another squared length >= 0; nothing stays nothing."""
    old = squared(v)
    return v * root(where(old > 0.0, square / where(old > 0.0, old, 1.0), 0.0))


RECORD = Compensation(
    name="printed",
    words="The compensation as published: it makes returning waves longer and generates energy.",
    linear="none",
    make=lambda params, users: AsPublished(users, period=params.period_s),
)
