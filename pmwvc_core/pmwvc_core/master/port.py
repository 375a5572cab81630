# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of the wave channel: motion in, force and outgoing wave out.

Every tick (App. B Fig. 1)::

    v      the returning wave, expanded to the ticks of its frame by the hold
    F_m = b xd - sqrt(2b) v_m,   u_m = sqrt(2b) xd - v_m
    u_m_lp, u_tx: the anti-aliasing filter, and every M-th of its outputs

so that F_m xd = (u_m^2 - v_m^2)/2. Without anything in between v_m = v. Port filters
(:mod:`.port_filters`: velocity filter, filter bank) let through w of v and answer u_m on the spot,
so that

    v_m = w + g u_m,   u_m = (sqrt(2b) xd - w)/(1 + g)

The safety limits may let another force F through. Then u_m is shortened until the port emits no
more than it gets, with the parts' answer to the shorter wave::

    |u_m|^2/2 <= |w + g u_m|^2/2 + F xd

Only a limit on the change of force can make this impossible (an old force still pushing when the
motion has turned); what it gave away then, ``debt_j``, is kept back from later waves. A silent
server is a wave v = 0, reached through the hold: F_m = b xd, a matched damper.

Not here: limits (``safety``), packets, time.

Equations: docs/theory.md 10.1.
"""

import dataclasses
import math
from collections.abc import Mapping

from pmwvc_core.master.filter_bank import make_bank
from pmwvc_core.master.port_filters import PortFilter, make_port_filters
from pmwvc_core.master.position import make_position_feedback
from pmwvc_core.master.velocity_filter import EquivalentVelocityFilter, make_force_velocity
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
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.wave.filters import AntiAliasing
from pmwvc_core.wave.impedance import impedance_of
from pmwvc_core.wave.rates import Hold
from pmwvc_core.wave.transform import WavePort


class WaveMaster(Stateful):
    """The wave port of a device; see the module. At rest, with both waves zero, at first.

    Parameters
    ----------
    params
        Impedance, filter, rate drop, hold, and what stands around the port; numbers may be
        ``(runs, 1)``.
    """

    BLOCKS = "_hold _filter _port_filters _velocity _position"
    MEMORY = (
        "u_m u_m_lp v_m f_m _x _xd _held _gain debt_j energy_u_m energy_u_tx energy_v_rx "
        "energy_v_m _packets _before"
    )
    flags = 0

    def __init__(self, params: MasterParams) -> None:
        self.params: MasterParams = params
        self._before: dict[str, Value] = {}
        self._port_filters: list[PortFilter] = []
        self._velocity: EquivalentVelocityFilter | None = None
        self._bank = make_bank(params, self.position)
        self._begin(params)
        self._position = make_position_feedback(params)
        self.u_m: Value = 0.0
        self.u_m_lp: Value = 0.0
        self.v_m: Value = 0.0
        self.f_m: Value = 0.0
        self.debt_j: Value = 0.0
        self.energy_u_m: Value = 0.0
        self.energy_u_tx: Value = 0.0
        self.energy_v_rx: Value = 0.0
        self.energy_v_m: Value = 0.0
        self._packets = 0  # sent, which is how their sender numbers them
        self._x: Value = 0.0
        self._xd: Value = 0.0
        self._held: Value = 0.0  # w: what is in v_m whatever u_m
        self._gain: Value = 0.0  # g

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over at a frame start; tick and rate drop stay.

        Waves carry the same power whatever the impedance, so that may change at any time, and so
        may position feedback and local model. Another filter, hold or part starts at zero: what
        the old one held is lost, never gained.
        """
        old = self.params
        same = dataclasses.replace(
            params,
            impedance=old.impedance,
            position=old.position,
            bank=old.bank,
            local_model=old.local_model,
        )
        if same == old:
            self.params = params
            self._match(params)
        else:
            self._begin(params)
        if self._bank:
            self._bank.configure(params)
        if self._position:
            self._position.configure(params)
        else:
            self._position = make_position_feedback(params)

    def _begin(self, params: MasterParams) -> None:
        """Start filter, hold and what is in between at rest; accounts go on."""
        self._before = self._between()
        self.params = params
        self._match(params)
        self._tick_s, self._half_s = params.tick_s, 0.5 * params.tick_s
        self._frame_s = params.frame_s
        self._hold = Hold(params.hold, ticks=params.rate_drop)
        self._filter = AntiAliasing(
            params.filter, tick_s=params.tick_s, rate_drop=params.rate_drop
        )
        self._port_filters = make_port_filters(params, self._bank)
        self._velocity = make_force_velocity(params)

    def _match(self, params: MasterParams) -> None:
        self._port = WavePort(impedance_of(params))

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energies of velocity filter, filter bank and position feedback [J]."""
        found = self._between()
        for own in (self._bank, self._position):
            if own:
                found |= own.accounts
        return found

    def _between(self) -> dict[str, Value]:
        """Return the energies of what starts anew, with what went before a change of it [J]."""
        if not self._port_filters and not self._velocity:
            return {}
        found = [each.accounts for each in self._port_filters if each is not self._bank]
        if self._velocity:
            found.append(self._velocity.accounts)
        before = self._before
        return {
            name: before.get(name, 0.0) + value
            for accounts in found
            for name, value in accounts.items()
        }

    def account(self) -> None:
        """Leave the packet's energy to the sum of its waves."""

    def on_packet(self, packet: WavePacket) -> None:
        """Note the avatar's position."""
        if self._position:
            self._position.on_packet(packet)

    def receive(self, wave: Value) -> None:
        """Take the newest wave [sqrt(W)]; it stands for the frame that begins."""
        self.energy_v_rx = self.energy_v_rx + squared(wave) * (0.5 * self._frame_s)
        if self._position:
            self._position.receive()
        self._hold.load(wave)

    def silence(self) -> None:
        """Let the returning wave go to zero: the port becomes a matched damper."""
        if self._position:
            self._position.silence()
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
        both = x + xd
        if not (math.isfinite(both) if type(both) is float else finite(both)):
            x = where(absolute(x) < math.inf, x, self._x)
            xd = where(absolute(xd) < math.inf, xd, 0.0)
        self._x, self._xd = x, xd
        v_m = self._hold.step()
        if self._position:
            v_m = self._position.down(v_m, x)
        if self._port_filters:
            v_m = self._answered(v_m, xd)
        self.v_m = v_m
        self.u_m = self._port.u(xd, v_m)
        if self._velocity:
            xd = self._velocity.step(xd, self._port.b)
        self.f_m = f_m = self._port.force(xd, v_m)
        return f_m

    def _answered(self, v: Value, xd: Value) -> Value:
        """Return v_m with the answer of the parts to the wave that fits it."""
        gain: Value = 0.0
        answer: Value = 0.0
        for each in reversed(self._port_filters):
            v = each.down(v)
            own, slope = each.offer()
            answer, gain = answer + own, gain + slope
        self._held, self._gain = v + answer, gain
        natural = self._port.u(xd, self._held)
        return self._held + gain * natural / (1.0 + gain)

    def applied(self, f: Value) -> None:
        """Pay for the force that was applied [N], then let the wave pass on to the filter."""
        owes = self.debt_j > 0.0
        if (f is not self.f_m and anywhere(f != self.f_m)) or (
            owes is not False and anywhere(owes)
        ):
            self._shorten(f)
        u_m, half_s = self.u_m, self._half_s
        self.energy_v_m = self.energy_v_m + squared(self.v_m) * half_s
        self.energy_u_m = self.energy_u_m + squared(u_m) * half_s
        for each in self._port_filters:
            u_m = each.step(u_m)
        if self._position:
            self._position.applied(u_m, f, self._xd)
        self.u_m_lp = self._filter.step(u_m)

    def _shorten(self, f: Value) -> None:
        """Shorten the outgoing wave to what v_m and F xd pay for after the debt."""
        if self._port_filters:
            self._shorten_answered(f)
            return
        owed = 2.0 * self.debt_j / self._tick_s  # [W]
        natural = squared(self.u_m)
        # The difference is formed from the two forces, so that equal forces cancel exactly.
        budget = natural + 2.0 * dot(f - self.f_m, self._xd) - owed
        short = budget < natural
        ratio = root(maximum(budget, 0.0) / where(natural > 0.0, natural, 1.0))
        self.u_m = where(short, self.u_m * minimum(ratio, 1.0), self.u_m)
        spent = where(short, maximum(budget, 0.0), natural)
        self.debt_j = maximum((spent - budget) * self._half_s, 0.0)

    def _shorten_answered(self, f: Value) -> None:
        """Find the longest s u_m, s <= 1, with |s u|^2 <= |w + g s u|^2 + 2 F xd - owed.

        That is a s^2 - 2 c s <= p with a = |u|^2 - |g u|^2 > 0, c = w . g u.
        """
        owed = 2.0 * self.debt_j / self._tick_s  # [W]
        answer = self._gain * self.u_m
        a = squared(self.u_m) - squared(answer)
        c = dot(self._held, answer)
        natural = a - 2.0 * c  # what p has to be for s = 1
        missing = 2.0 * dot(f - self.f_m, self._xd) - owed
        p = natural + missing
        at_best = maximum(c * c + a * p, 0.0)
        ratio = (c + root(at_best)) / where(a > 0.0, a, 1.0)
        ratio = where(missing < 0.0, maximum(minimum(ratio, 1.0), 0.0), 1.0)
        self.u_m = ratio * self.u_m
        self.v_m = self._held + self._gain * self.u_m
        given = (a * ratio - 2.0 * c) * ratio - p
        self.debt_j = maximum(given * self._half_s, 0.0)

    def send(self) -> Value:
        """Return the filter's output after the last tick [sqrt(W)]."""
        wave = self._filter.sample()
        self._packets += 1
        if self._position:
            wave = self._position.send(wave, self._packets)
        self.energy_u_tx = self.energy_u_tx + squared(wave) * (0.5 * self._frame_s)
        return wave

    def position(self) -> Value:
        """Return the position last measured [m]."""
        return self._x
