# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of the plain wave channel: motion in, force and outgoing wave out.

Every tick (App. B Fig. 1)::

    v      the returning wave, expanded to the ticks of its frame by the hold
    F_m = b xd - sqrt(2b) v_m,   u_m = sqrt(2b) xd - v_m
    u_m_lp, u_tx: the anti-aliasing filter, and every M-th of its outputs

so that F_m xd = (u_m^2 - v_m^2)/2. Without anything in between v_m = v; port filters add an answer
of their own (:mod:`.device_port`). The safety limits may let another force F through. Then u_m is
shortened until the port emits no more than it gets, with the parts' answer to the shorter wave::

    |u_m|^2/2 <= |w + g u_m|^2/2 + F xd

Only a limit on the change of force can make this impossible (an old force still pushing when the
motion has turned); what it gave away then, ``deficit_j``, is kept back from later waves. A silent
server is a wave v = 0, reached through the hold: F_m = b xd, a matched damper.

Not here: limits (``safety``), packets, time.

Equations: docs/theory.md 10.1.
"""

from collections.abc import Mapping

from pmwvc_core.master.device_port import DevicePort
from pmwvc_core.master.position.feedback import make_position_feedback
from pmwvc_core.numeric import Value, anywhere, dot, maximum, minimum, root, squared, where
from pmwvc_core.params import MasterParams
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.wave.rates import AntiAliasing, Hold


class WaveMaster(DevicePort):
    """The wave port of a device; see the module. At rest, with both waves zero, at first.

    Parameters
    ----------
    params
        Impedance, filter, rate drop, hold, and what stands around the port; numbers may be
        ``(runs, 1)``.
    """

    BLOCKS = "_hold _filter _position"
    MEMORY = "_packets _xd deficit_j energy_u_m energy_u_tx energy_v_rx energy_v_m"

    def __init__(self, params: MasterParams) -> None:
        super().__init__(params)
        self._position = make_position_feedback(params)
        self._packets = 0  # sent, which is how their sender numbers them
        self.deficit_j: Value = 0.0
        self.energy_u_m: Value = 0.0
        self.energy_u_tx: Value = 0.0
        self.energy_v_rx: Value = 0.0
        self.energy_v_m: Value = 0.0
        self._xd: Value = 0.0

    def _begin_channel(self, params: MasterParams) -> None:
        self._frame_s = params.frame_s
        self._hold = Hold(params.hold, ticks=params.rate_drop)
        self._filter = AntiAliasing(
            params.filter, tick_s=params.tick_s, rate_drop=params.rate_drop
        )

    def _configure_position(self, params: MasterParams) -> None:
        if self._position:
            self._position.configure(params)
        else:
            self._position = make_position_feedback(params)

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energies of velocity filter, filter bank and position feedback [J]."""
        return {**super().accounts, **(self._position.accounts if self._position else {})}

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
        self._x, self._xd = x, xd = self._sensed(x, xd)
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

    def applied(self, f: Value) -> None:
        """Pay for the force that was applied [N], then let the wave pass on to the filter."""
        short = self.deficit_j > 0.0
        if (f is not self.f_m and anywhere(f != self.f_m)) or (
            short is not False and anywhere(short)
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
        """Shorten the outgoing wave to what v_m and F xd pay for after the deficit."""
        if self._port_filters:
            self._shorten_answered(f)
            return
        deficit = 2.0 * self.deficit_j / self._tick_s  # [W]
        natural = squared(self.u_m)
        # The difference is formed from the two forces, so that equal forces cancel exactly.
        budget = natural + 2.0 * dot(f - self.f_m, self._xd) - deficit
        short = budget < natural
        ratio = root(maximum(budget, 0.0) / where(natural > 0.0, natural, 1.0))
        self.u_m = where(short, self.u_m * minimum(ratio, 1.0), self.u_m)
        spent = where(short, maximum(budget, 0.0), natural)
        self.deficit_j = maximum((spent - budget) * self._half_s, 0.0)

    def _shorten_answered(self, f: Value) -> None:
        """Find the longest s u_m, s <= 1, with |s u|^2 <= |w + g s u|^2 + 2 F xd - deficit.

        That is a s^2 - 2 c s <= p with a = |u|^2 - |g u|^2 > 0, c = w . g u.
        """
        deficit = 2.0 * self.deficit_j / self._tick_s  # [W]
        answer = self._gain * self.u_m
        a = squared(self.u_m) - squared(answer)
        c = dot(self._held, answer)
        natural = a - 2.0 * c  # what p has to be for s = 1
        missing = 2.0 * dot(f - self.f_m, self._xd) - deficit
        p = natural + missing
        at_best = maximum(c * c + a * p, 0.0)
        ratio = (c + root(at_best)) / where(a > 0.0, a, 1.0)
        ratio = where(missing < 0.0, maximum(minimum(ratio, 1.0), 0.0), 1.0)
        self.u_m = ratio * self.u_m
        self.v_m = self._held + self._gain * self.u_m
        given = (a * ratio - 2.0 * c) * ratio - p
        self.deficit_j = maximum(given * self._half_s, 0.0)

    def send(self) -> Value:
        """Return the filter's output after the last tick [sqrt(W)]."""
        wave = self._filter.sample()
        self._packets += 1
        if self._position:
            wave = self._position.send(wave, self._packets)
        self.energy_u_tx = self.energy_u_tx + squared(wave) * (0.5 * self._frame_s)
        return wave
