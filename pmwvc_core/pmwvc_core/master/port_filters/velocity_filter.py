# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity filter by feeding back the high-pass part of the outgoing wave (App. D).

A share s (half, in App. D) of H_HP u_m comes back at once, so that the velocity, which is most of
u_m at high frequency, and its noise do not reach the hand:

exact (App. D Fig. 1)
    v_m = w + s H_HP u_m with w the wave from the server. As u_m = sqrt(2b) xd - v_m this is a
    loop; it is solved. F_m = b (1 - s H)/(1 + s H) xd - sqrt(2b) w/(1 + s H). Its part of the wave
    is spent twice, here and at the low-pass filter behind it: what it gives out that filter pays
    for where ``|H_LP| + s |H_HP| <= 1`` (:mod:`pmwvc_core.wave.design.branches`).
equivalent (App. D Fig. 2, Eq. 3 and 2)
    F_m = b (1 - 2 s H_HP) xd - sqrt(2b) v_m, u_m = sqrt(2b) xd - v_m: of the velocity that is
    fed back only the first term of u_m. The wave goes out as before, so more energy leaves on it
    than the device has given: b (2 s H_HP xd) xd, which the account shows.
complementary (ours)
    v_m = H_1 w + s H_2 H_2 u_m, and H_1 u_m goes on, with |H_1|^2 + |H_2|^2 = 1. Passive by itself
    at every tick for s <= 1, as [H_1 H_2] keeps energy; whatever stands behind it.

Every account is the energy that the filter has kept [J]; below zero it has given it out. All
states are zero at first. Which filters: :mod:`pmwvc_core.wave.design.velocity_filter_design`.

Equations: docs/theory.md 7.1, 7.2, 7.3.
"""

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from pmwvc_core.account import Entry, Role
from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Value, dot, squared
from pmwvc_core.params import MasterParams
from pmwvc_core.state import Stateful
from pmwvc_core.wave.cascade import Cascade
from pmwvc_core.wave.design.velocity_filter_design import high_pass, low_pass
from pmwvc_core.wave.transform import WavePort

IN_WAVE = Entry(
    "velocity_filter", "kept by the velocity filter", Role.TAKEN, part="velocity filter"
)
IN_FORCE = Entry(
    "force_velocity_filter",
    "kept by the velocity filter of the force",
    Role.WITHIN,
    part="velocity filter of the force",
)
ENTRIES = (IN_WAVE, IN_FORCE)


class ExactVelocityFilter(Stateful):
    """Feeds back a share of the high-pass part, and lets the wave pass; see the module."""

    BLOCKS = "_high"
    MEMORY = "_w _kept"

    def __init__(self, params: MasterParams) -> None:
        self._share = params.velocity_filter.share
        self._half_tick_s = 0.5 * params.tick_s
        self._high = Cascade(high_pass(params))
        self._gain = self._share * self._high.gain
        self._w: Value = 0.0
        self._kept: Value = 0.0

    def down(self, v: Value) -> Value:
        """Let the wave pass."""
        self._w = v
        return v

    def offer(self) -> tuple[Value, Value]:
        """Return s times what the high-pass filter will give."""
        return self._share * self._high.rest(), self._gain

    def step(self, u: Value) -> Value:
        """Take the wave of the tick; all of it goes on."""
        w = self._w
        back = w + self._share * self._high.step(u)
        self._kept = self._kept + (squared(w) - squared(back)) * self._half_tick_s
        return u

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energy kept, less than none where the low-pass filter has to pay [J]."""
        return {IN_WAVE.name: self._kept}


class ComplementaryVelocityFilter(Stateful):
    """Feeds back a share of the high-pass part, and low-pass filters what passes, both ways."""

    BLOCKS = "_up _down _first _second"
    MEMORY = "_w _passed _kept"

    def __init__(self, params: MasterParams) -> None:
        self._share = params.velocity_filter.share
        self._half_tick_s = 0.5 * params.tick_s
        low = low_pass(params)
        high = high_pass(params)
        self._up, self._down = Cascade(low), Cascade(low)
        self._first, self._second = Cascade(high), Cascade(high)
        self._gain = self._share * self._first.gain * self._second.gain
        self._w: Value = 0.0
        self._passed: Value = 0.0
        self._kept: Value = 0.0

    def down(self, v: Value) -> Value:
        """Return H_1 of the wave."""
        self._w = v
        self._passed = self._down.step(v)
        return self._passed

    def offer(self) -> tuple[Value, Value]:
        """Return s times what the two high-pass filters will give."""
        second = self._second
        rest = second.gain * self._first.rest() + second.rest()
        return self._share * rest, self._gain

    def step(self, u: Value) -> Value:
        """Take the wave of the tick; return H_1 of it."""
        on = self._up.step(u)
        back = self._passed + self._share * self._second.step(self._first.step(u))
        kept = squared(u) - squared(on) + squared(self._w) - squared(back)
        self._kept = self._kept + kept * self._half_tick_s
        return on

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energy kept, never less than none [J]."""
        return {IN_WAVE.name: self._kept}


class EquivalentVelocityFilter(Stateful):
    """Filters the velocity in the force, not in the wave; see the module."""

    BLOCKS = "_high"
    MEMORY = "_kept"

    def __init__(self, params: MasterParams) -> None:
        self._twice = 2.0 * params.velocity_filter.share
        self._tick_s = params.tick_s
        self._high = Cascade(high_pass(params))
        self._kept: Value = 0.0

    def step(self, xd: Value, impedance: Any) -> Value:
        """Return the velocity for the force of a tick, (1 - 2 s H_HP) xd [m/s].

        Parameters
        ----------
        xd
            Velocity [m/s].
        impedance
            b [N s/m], which gives the cost of the difference.
        """
        less = self._twice * self._high.step(xd)
        self._kept = self._kept - dot(impedance * less, xd) * self._tick_s
        return xd - less

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energy kept, less than none where the device gave less than left on the wave [J]."""
        return {IN_FORCE.name: self._kept}


def force_filter_kept(f_m: Value, xd: Value, v_m: Value, port: WavePort, dt: float) -> Value:
    """Return the energy that the equivalent filter kept in a tick [J], (F_m - b xd + sqrt(2b) v_m)
    . xd dt: below none where the device gave less than left on the wave.
    """
    return dot(f_m - port.force(xd, v_m), xd) * dt


InWaves: TypeAlias = ExactVelocityFilter | ComplementaryVelocityFilter
IN_WAVES: Mapping[str, Callable[[MasterParams], InWaves]] = {
    "exact": ExactVelocityFilter,
    "complementary": ComplementaryVelocityFilter,
}


def make_velocity_filter(params: MasterParams) -> InWaves | None:
    """Return the filter as a part of the wave port, or None where there is none.

    Raises
    ------
    ParameterError
        If no such filter exists, or it does not go with the filter bank.
    """
    own = params.velocity_filter
    if own.splits and params.bank.is_on:
        raise ParameterError(
            f"bank.kind = {params.bank.kind}: must be none with velocity_filter.kind = "
            f"{own.kind}, which splits the wave itself"
        )
    make = IN_WAVES.get(own.kind)
    return make(params) if make else None


def make_force_velocity(params: MasterParams) -> EquivalentVelocityFilter | None:
    """Return what filters the velocity in the force, or None where nothing does."""
    return EquivalentVelocityFilter(params) if params.velocity_filter.in_force else None
