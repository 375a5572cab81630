# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energetic compensation with its sign corrected: it keeps credit and only shortens waves.

::

    deficit(n) = deficit(n-1) + sum over users [F(n)^2 - F(n) F'(n)]/b - pay(n-1)          [W]
    pay(n)  = min(max(deficit, 0), sum |v|^2/2),   each v in proportion to its length

so that sum (|u|^2 - |v|^2)/2 = sum F xd - deficit. Where the deficit is not above zero the port
has taken no less than the environment; where it is, nothing is returned and the balance only
grows. Hence it never falls below zero where sum F xd never does. For several users that holds of
all together only, so the deficit is one.

Credit (a deficit below zero) is what a falling force gives back; it pays for the next rise and
never makes a wave longer. An environment that is active itself is not held back.

Equations: docs/theory.md 5.7.
"""

from collections.abc import Mapping, Sequence

from pmwvc_core.account import Entry, Role
from pmwvc_core.numeric import Value, maximum, minimum, root, squared, where
from pmwvc_core.server.compensations.record import Compensation, Wave
from pmwvc_core.state import Stateful

DEFICIT = Entry("debt", "deficit, recovered from later waves", Role.LEVEL)


class Corrected(Stateful):
    """Take from the waves what late decoding added to them."""

    MEMORY = "_deficit"

    def __init__(self, *, period: float) -> None:
        self._period = period
        self._deficit: Value = 0.0  # [W]

    @property
    def accounts(self) -> Mapping[str, Value]:
        """``debt``: what later waves still have to pay; below zero: credit."""
        return {DEFICIT.name: self._period * self._deficit}

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return the waves made shorter."""
        deficit, have = self._deficit, 0.0 * self._deficit
        for wave in waves:
            deficit = deficit - wave.late
            have = have + 0.5 * squared(wave.v)
        pay = minimum(maximum(deficit, 0.0), have)
        self._deficit = deficit - pay
        ratio = root(where(have > 0.0, (have - pay) / where(have > 0.0, have, 1.0), 1.0))
        return [wave.v * ratio for wave in waves]


RECORD = Compensation(
    name="corrected",
    words="Returning waves are shortened by what late decoding added.",
    linear="none",
    make=lambda params, users: Corrected(period=params.period_s),
    limits=True,
    accounts=(DEFICIT,),
)
