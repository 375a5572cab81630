# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Filter bank with a local model on the high-pass part of the outgoing wave (App. E).

Fig. 3, with the names of its filters here::

    u_m --> low_up ---> anti-aliasing filter, packets --> server
        '-> high_up --> u2 --> local model --> v2 --> high_down -,
    v_m <---------------- w <-- low_down <-- hold <-- server --(+)

``dissertation``: low_up and low_down are wires, high_up is HP, high_down is LP2. The server
receives what the anti-aliasing filter leaves and the local model what HP leaves, but nothing keeps
the two answers together below what came: for a passive server and a passive local model the wave
that comes back is bounded by (|LP1| + |LP2| |HP|) |u_m|, which is above 1 for the filters of Table
1.

``complementary``: the same first-order pair splits and puts together, |H1|^2 + |H2|^2 = 1. With
H = (H1, H2): H^T H = 1 up to the pair's own storage, so |u1|^2 + |u2|^2 = |u_m|^2 in the end and
never more on the way, and |H1 v1 + H2 v2|^2 <= |v1|^2 + |v2|^2: passive for any passive server and
local model. Where both reflect fully, H1^2 + H2^2 = (s^2 + a^2)/(s + a)^2 vanishes at a: there the
device meets a matched damper, whatever there is to feel.

The local model answers within the tick: v_m = w + v0 + g u_m with g = HD (b - G)/(b + G) HU, the
gains of the high filters on the spot and of the model's port.

Equations: docs/theory.md 8.4.
"""

from collections.abc import Callable, Mapping

from pmwvc_core.account import Entry, Role
from pmwvc_core.master.port_filters.local_model import LocalPort
from pmwvc_core.numeric import Array, Value
from pmwvc_core.params import MasterParams
from pmwvc_core.state import Stateful
from pmwvc_core.wave.cascade import Cascade
from pmwvc_core.wave.design.bank_design import bank_filters
from pmwvc_core.wave.ledger import EnergyLedger

ENTRIES = LOW_IN, LOW_OUT, HIGH_IN, HIGH_OUT = (
    Entry("bank_low_in", "to the server, behind the bank", Role.WITHIN),
    Entry("bank_low_out", "from the server, before the bank", Role.WITHIN),
    Entry("bank_high_in", "to the local model", Role.WITHIN),
    Entry("bank_high_out", "from the local model", Role.WITHIN),
)


class FilterBank(Stateful):
    """See the module. At rest at first.

    Parameters
    ----------
    params
        Bank, local model, impedance and tick; numbers may be ``(runs, 1)``.
    position
        Returns the device's position [m].
    """

    BLOCKS = "_low_up _low_down _high_up _high_down _local _low_in _low_out _high_in _high_out"

    def __init__(self, params: MasterParams, position: Callable[[], Value]) -> None:
        self._begin(params)
        self._local = LocalPort(params, position)
        self._tick_s = params.tick_s
        self._low_in, self._low_out = EnergyLedger(), EnergyLedger()
        self._high_in, self._high_out = EnergyLedger(), EnergyLedger()

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over: another split starts at zero, another spring at rest."""
        if params.bank != self._params:
            self._begin(params)
        self._local.configure(params)

    def _begin(self, params: MasterParams) -> None:
        self._params = params.bank
        filters = bank_filters(params.bank, tick_s=params.tick_s)
        self._low_up, self._low_down = _maybe(filters.low_up), _maybe(filters.low_down)
        self._high_up, self._high_down = Cascade(filters.high_up), Cascade(filters.high_down)

    def down(self, v: Value) -> Value:
        """Return the low branch of the wave from the server."""
        self._low_out.add(v, self._tick_s)
        return v if self._low_down is None else self._low_down.step(v)

    def offer(self) -> tuple[Value, Value]:
        """Return v0 and g of what the local model will answer through the high branch."""
        up, down = self._high_up, self._high_down
        v0, gain = self._local.offer()
        return down.rest() + down.gain * (v0 + gain * up.rest()), gain * (up.gain * down.gain)

    def step(self, u: Value) -> Value:
        """Have the local model answer; return the low branch."""
        u2 = self._high_up.step(u)
        v2 = self._local.step(u2)
        self._high_down.step(v2)
        low = u if self._low_up is None else self._low_up.step(u)
        self._low_in.add(low, self._tick_s)
        self._high_in.add(u2, self._tick_s)
        self._high_out.add(v2, self._tick_s)
        return low

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energy of the waves of either branch, to and from server and local model [J]."""
        return {
            LOW_IN.name: self._low_in.energy_j,
            LOW_OUT.name: self._low_out.energy_j,
            HIGH_IN.name: self._high_in.energy_j,
            HIGH_OUT.name: self._high_out.energy_j,
            **self._local.accounts,
        }


def make_bank(params: MasterParams, position: Callable[[], Value]) -> FilterBank | None:
    """Return the bank as a part of the wave port, or None where there is none."""
    return FilterBank(params, position) if params.bank.is_on else None


def _maybe(sos: Array | None) -> Cascade | None:
    return None if sos is None else Cascade(sos)
