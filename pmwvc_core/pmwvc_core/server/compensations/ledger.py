# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The port ledger: all users together get back no more than they gave, and a declared allowance.

::

    tank += h sum |u_i|^2/2
    cost  = h sum |v_i|^2/2
    v_i  *= sqrt(tank/cost)   where cost > tank, all by the same factor
    tank -= h sum |v_i|^2/2
    tank  = min(tank, cap)

One tank for all, as energy may enter at one user and leave at another. Whatever the environment
does: given back <= received + allowance, at every step.

Allowance: where the tank does not reach, up to ``allowance_w`` is added at any time, up to
``allowance_j`` in all. Cap: what can still come out, or ``cap_j`` where the environment does not
report its stored energy, so that energy saved for minutes is not released at once. A spring with K
h <= b, or a damper with 2 B <= b, can give back no more than that and never meets the limit.

Equations: docs/theory.md 5.8.
"""

from collections.abc import Mapping, Sequence

from pmwvc_core.account import Entry, Role
from pmwvc_core.numeric import Value, maximum, minimum, root, squared, where
from pmwvc_core.params import ServerParams
from pmwvc_core.server.compensations.record import Compensation, Wave
from pmwvc_core.state import Stateful

TANK = Entry("tank", "energy tank of the server port", Role.LEVEL)
GRANTED = Entry("granted", "taken from the allowance", Role.LEVEL)
CAPPED = Entry("capped", "received above the cap, not stored", Role.LEVEL)


class JointLedger(Stateful):
    """One tank for all users.

    Parameters
    ----------
    period
        Time step h [s].
    allowance_w, allowance_j
        Energy given without having been received: power [W] and total [J]; none unless both are
        above zero.
    cap_j
        Most that is kept for an environment that does not report its stored energy [J].
    """

    MEMORY = "_tank _granted _capped"

    def __init__(
        self, *, period: float, allowance_w: Value, allowance_j: Value, cap_j: Value
    ) -> None:
        self._half_period = 0.5 * period
        self._grant = period * allowance_w  # [J] per step
        self._allowance = allowance_j
        self._cap = cap_j
        self._tank: Value = 0.0
        self._granted: Value = 0.0
        self._capped: Value = 0.0

    @property
    def accounts(self) -> Mapping[str, Value]:
        """``tank``: may still be given back; ``granted``: taken from the allowance; ``capped``:
        received, but not kept.
        """
        return {TANK.name: self._tank, GRANTED.name: self._granted, CAPPED.name: self._capped}

    def step(self, waves: Sequence[Wave], stored: Value | None) -> list[Value]:
        """Return the waves, shorter where the tank does not pay for them."""
        have, cost = self._tank, 0.0 * self._tank
        for wave in waves:
            have = have + self._half_period * squared(wave.u)
            cost = cost + self._half_period * squared(wave.v)
        grant = minimum(self._grant, self._allowance - self._granted)
        grant = minimum(maximum(cost - have, 0.0), grant)
        self._granted = self._granted + grant
        have = have + grant
        short = cost > have
        ratio = root(where(short, have / where(short, cost, 1.0), 1.0))
        left = where(short, 0.0, have - cost)
        self._tank = minimum(left, self._cap if stored is None else stored)
        self._capped = self._capped + (left - self._tank)
        return [wave.v * ratio for wave in waves]


def _passive(params: ServerParams) -> bool:
    return bool(min(params.allowance_w, params.allowance_j) == 0)


def _allowance_j(params: ServerParams) -> float:
    return float(params.allowance_j) if params.allowance_w > 0.0 else 0.0


RECORD = Compensation(
    name="ledger",
    words="All users together get back no more energy than they gave, and a declared allowance.",
    linear="none",
    make=lambda params, users: JointLedger(
        period=params.period_s,
        allowance_w=params.allowance_w,
        allowance_j=params.allowance_j,
        cap_j=params.tank_cap_j,
    ),
    limits=True,
    passive=_passive,
    allowance_j=_allowance_j,
    accounts=(TANK, GRANTED, CAPPED),
)
