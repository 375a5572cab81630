# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of the wave channel: motion in, force and outgoing wave out.

Every tick (App. B Fig. 1)::

    v_m   the returning wave, expanded to the ticks of its frame by the hold
    F_m = b xd - sqrt(2b) v_m,   u_m = sqrt(2b) xd - v_m
    u_m_lp, u_tx: the anti-aliasing filter, and every M-th of its outputs

so that F_m xd = (u_m^2 - v_m^2)/2. The safety limits may let another force F through. Then u_m is
shortened until the port emits no more than it gets::

    |u_m|^2/2 <= |v_m|^2/2 + F xd

Only a limit on the change of force can make the right side negative (an old force still pushing
when the motion has turned); what it gave away then, ``debt_j``, is kept back from later waves.
A silent server is a wave v = 0, reached through the hold: F_m = b xd, a matched damper.

Not here: limits (``safety``), packets, time.
"""

import math
from typing import Protocol

from pmwvc_core.numeric import (
    Value,
    absolute,
    anywhere,
    dot,
    finite,
    maximum,
    minimum,
    root,
    squared,
    where,
)
from pmwvc_core.params import MasterParams
from pmwvc_core.wave.filters import AntiAliasing
from pmwvc_core.wave.rates import Hold
from pmwvc_core.wave.transform import decode_master, encode_master


class MasterController(Protocol):
    """What turns the device's motion into force and packets. Order within a frame: ``send``,
    ``receive``, then per tick ``step`` and ``applied``.

    Attributes
    ----------
    u_m, u_m_lp, v_m
        Wave out before and after the filter, wave in after the hold [sqrt(W)]; zero where a
        controller has no waves.
    energy_u_m, energy_u_tx, energy_v_rx, energy_v_m
        Running sums of |w|^2/2 times the period [J].
    flags
        ``FLAG_*`` of the packet.
    """

    u_m: Value
    u_m_lp: Value
    v_m: Value
    flags: int

    @property
    def energy_u_m(self) -> Value:
        """Energy of the outgoing wave before the filter [J]."""

    @property
    def energy_u_tx(self) -> Value:
        """Energy sent [J]."""

    @property
    def energy_v_rx(self) -> Value:
        """Energy received [J]."""

    @property
    def energy_v_m(self) -> Value:
        """Energy of the returning wave after the hold [J]."""

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over at a frame start; tick and rate drop stay."""

    def receive(self, wave: Value) -> None:
        """Take the newest wave, once a frame."""

    def silence(self) -> None:
        """Take a wave of zero instead, once a frame."""

    def measure(self, x: Value, xd: Value) -> None:
        """Note position [m] and velocity [m/s] at a frame start, for ``send`` and ``position``."""

    def step(self, x: Value, xd: Value) -> Value:
        """Return the force wanted for the tick that starts with this motion [N]."""

    def applied(self, f: Value) -> None:
        """Finish the tick with the force that safety let through [N]."""

    def send(self) -> Value:
        """Return the wave for the packet of this frame start."""

    def position(self) -> Value:
        """Return the position for the packet [m]."""


class WaveMaster:
    """The wave port of a device; see the module. At rest, with both waves zero, at first.

    Parameters
    ----------
    params
        Impedance, filter, rate drop and hold; numbers may be ``(runs, 1)``.
    """

    flags = 0

    def __init__(self, params: MasterParams) -> None:
        self.params: MasterParams = params
        self._begin(params)
        self.u_m: Value = 0.0
        self.u_m_lp: Value = 0.0
        self.v_m: Value = 0.0
        self.f_m: Value = 0.0
        self.debt_j: Value = 0.0
        self.energy_u_m: Value = 0.0
        self.energy_u_tx: Value = 0.0
        self.energy_v_rx: Value = 0.0
        self.energy_v_m: Value = 0.0
        self._x: Value = 0.0
        self._xd: Value = 0.0

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over at a frame start; tick and rate drop stay.

        Waves carry the same power whatever the impedance, so that may change at any time. Another
        filter or hold starts at zero: what the old one held is lost, never gained.
        """
        same = params.filter == self.params.filter and params.hold == self.params.hold
        if same:
            self.params, self._impedance = params, params.impedance
        else:
            self._begin(params)

    def _begin(self, params: MasterParams) -> None:
        """Start filter and hold at rest."""
        self.params = params
        self._impedance = params.impedance
        self._tick_s = params.tick_s
        self._frame_s = params.frame_s
        self._hold = Hold(params.hold, ticks=params.rate_drop)
        self._filter = AntiAliasing(
            params.filter, tick_s=params.tick_s, rate_drop=params.rate_drop
        )

    def receive(self, wave: Value) -> None:
        """Take the newest wave [sqrt(W)]; it stands for the frame that begins."""
        self.energy_v_rx = self.energy_v_rx + squared(wave) * (0.5 * self._frame_s)
        self._hold.load(wave)

    def silence(self) -> None:
        """Let the returning wave go to zero: the port becomes a matched damper."""
        self._hold.load(0.0 * self.v_m)

    def measure(self, x: Value, xd: Value) -> None:
        """Note the position, so that a packet sent before the first tick has it."""
        self._x = x

    def step(self, x: Value, xd: Value) -> Value:
        """Form the waves and the force of a tick.

        Parameters
        ----------
        x, xd
            Position [m] and velocity [m/s] measured at the start of the tick, ``(..., dof)``. What
            is not finite counts as the last position and as no velocity.

        Returns
        -------
        Value
            F_m [N], pushing against the hand.
        """
        if not (finite(x) and finite(xd)):
            x = where(absolute(x) < math.inf, x, self._x)
            xd = where(absolute(xd) < math.inf, xd, 0.0)
        self._x, self._xd = x, xd
        self.v_m = v_m = self._hold.step()
        self.energy_v_m = self.energy_v_m + squared(v_m) * (0.5 * self._tick_s)
        self.u_m = encode_master(xd, v_m, self._impedance)
        self.f_m = decode_master(xd, v_m, self._impedance)
        return self.f_m

    def applied(self, f: Value) -> None:
        """Pay for the force that was applied [N], then let the wave pass the filter."""
        if anywhere(f != self.f_m) or anywhere(self.debt_j > 0.0):
            self._shorten(f)
        u_m = self.u_m
        self.energy_u_m = self.energy_u_m + squared(u_m) * (0.5 * self._tick_s)
        self.u_m_lp = self._filter.step(u_m)

    def _shorten(self, f: Value) -> None:
        """Shorten the outgoing wave to what v_m and F xd pay for after the debt."""
        owed = 2.0 * self.debt_j / self._tick_s  # [W]
        natural = squared(self.u_m)
        # The difference is formed from the two forces, so that equal forces cancel exactly.
        budget = natural + 2.0 * dot(f - self.f_m, self._xd) - owed
        short = budget < natural
        share = root(maximum(budget, 0.0) / where(natural > 0.0, natural, 1.0))
        self.u_m = where(short, self.u_m * minimum(share, 1.0), self.u_m)
        spent = where(short, maximum(budget, 0.0), natural)
        self.debt_j = maximum((spent - budget) * (0.5 * self._tick_s), 0.0)

    def send(self) -> Value:
        """Return the filter's output after the last tick [sqrt(W)]."""
        wave = self._filter.sample()
        self.energy_u_tx = self.energy_u_tx + squared(wave) * (0.5 * self._frame_s)
        return wave

    def position(self) -> Value:
        """Return the position last measured [m]."""
        return self._x
