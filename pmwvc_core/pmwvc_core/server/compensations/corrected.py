# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energetic compensation with its sign corrected: it keeps credit and only shortens waves.

::

    debt(n) = debt(n-1) + sum over users [F(n)^2 - F(n) F'(n)]/b - pay(n-1)          [W]
    pay(n)  = min(max(debt, 0), sum |v|^2/2),   each v in proportion to its length

so that sum (|u|^2 - |v|^2)/2 = sum F xd - debt. Where the debt is not above zero the port has
taken no less than the environment; where it is, nothing is returned and the balance only grows.
Hence it never falls below zero where sum F xd never does. For several users that holds of all
together only, so the debt is one.

Credit (a debt below zero) is what a falling force gives back; it pays for the next rise and never
makes a wave longer. An environment that is active itself is not held back.

Equations: docs/theory.md 5.7.
"""

from collections.abc import Mapping, Sequence

from pmwvc_core.account import Entry, Role
from pmwvc_core.numeric import Value, maximum, minimum, root, squared, where
from pmwvc_core.server.compensations.record import Compensation, Wave
from pmwvc_core.state import Stateful

DEBT = Entry("debt", "deficit, recovered from later waves", Role.LEVEL)


class Corrected(Stateful):
    """Take from the waves what late decoding added to them."""

    MEMORY = "_debt"

    def __init__(self, *, period: float) -> None:
        self._period = period
        self._debt: Value = 0.0  # [W]

    @property
    def accounts(self) -> Mapping[str, Value]:
        """``debt``: what later waves still have to pay; below zero: credit."""
        return {DEBT.name: self._period * self._debt}

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return the waves made shorter."""
        debt, have = self._debt, 0.0 * self._debt
        for wave in waves:
            debt = debt - wave.late
            have = have + 0.5 * squared(wave.v)
        pay = minimum(maximum(debt, 0.0), have)
        self._debt = debt - pay
        ratio = root(where(have > 0.0, (have - pay) / where(have > 0.0, have, 1.0), 1.0))
        return [wave.v * ratio for wave in waves]


RECORD = Compensation(
    name="corrected",
    words="Returning waves are shortened by what late decoding added.",
    linear="none",
    make=lambda params, users: Corrected(period=params.period_s),
    limits=True,
    accounts=(DEBT,),
)
