# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The position error between device and avatar, and the part that waves in flight explain.

At either port xd = (u + v)/sqrt(2b), so with U, V the integrals of the waves

    sqrt(2b) (x_m - x_s - x_ref) = (U_m - U_s) - (V_s - V_m),

the waves on their way to the server less those on their way back. Known are the wave in the
filter (group delay tau, sampled at frame ends), those sent after the packet that the server has
answered (its echo names it), the packet that is about to be played, and the wave in the hold::

    lag = [tau - (M-1)/2 T_c] y + integral of u since + (U_tx - U_tx(echo)) - w T - (M-1)/2 T_c v

(the last term for the first-order hold). The residual is lost or distorted motion: lost
packets, saturation, aliasing. ``x_ref`` makes the residual zero at the first packet of an avatar:
its position then (before the face of the object, late) does not count.

Only signals known at this end enter; the delay of the link may change. Both ends need equal
impedances: with others the avatar moves on another scale.

Equations: docs/theory.md 9.2, 9.3.
"""

from typing import Any

from pmwvc_core.master.position.lags import filter_lag_s, hold_lag_s
from pmwvc_core.numeric import Value, root, truth
from pmwvc_core.params import MasterParams
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import FLAG_ANEW, WavePacket
from pmwvc_core.wave.impedance import impedance_of

KEPT = 1024  # packets sent whose integral is kept
SMOOTHED_S = 0.5  # time constant of the round trip as packets show it


class PositionError(Stateful):
    """x_m - x_s - x_ref, with x_s of the newest packet [m].

    Zero until an avatar's first packet, and where the echo is of a packet not remembered.

    Attributes
    ----------
    scale
        sqrt(2b): wave per distance [sqrt(N s/m)].
    round_trip_s
        Lag of slow motion once around [s]; 0: not known yet.
    """

    SIGNALS = "_avatar_x"
    MEMORY = "_integral _since _y _v _sent _avatar _packet _fresh _reference _newest round_trip_s"

    def __init__(self, params: MasterParams) -> None:
        self._integral: Value = 0.0  # U_tx
        self._sent: dict[int, Value] = {}  # number of a packet: U_tx with it
        self._since: Value = 0.0
        self._y: Value = 0.0
        self._v: Value = 0.0
        self._avatar: tuple[int, int] | None = None
        self._packet: WavePacket | None = None
        self._avatar_x: Value = 0.0  # of the avatar, by the newest packet [m]
        self._fresh = False
        self._reference: Value | None = None
        self._newest = 0  # number of the packet last sent
        self.round_trip_s: Value = 0.0
        self.configure(params)

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over; the reference stays."""
        self._tick_s = params.tick_s
        self._frame_s = params.frame_s
        self.scale: Any = root(2.0 * impedance_of(params))
        self._hold_s = hold_lag_s(params)
        self._filter_s = filter_lag_s(params)

    def send(self, y: Value, sent: Value, seq: int) -> None:
        """Note the filter's output, and what of it packet number ``seq`` carries [sqrt(W)]."""
        self._newest = seq
        self._y, self._since = y, 0.0
        self._integral = self._integral + sent * self._frame_s
        self._sent[seq] = self._integral
        self._sent.pop(seq - KEPT, None)

    def take(self, u: Value) -> None:
        """Note the wave that goes to the filter in a tick [sqrt(W)]."""
        self._since = self._since + u * self._tick_s

    def on_packet(self, packet: WavePacket) -> None:
        """Note the newest packet."""
        newest = self._packet
        if newest and (packet.epoch, packet.seq) == (newest.epoch, newest.seq):
            return
        avatar = packet.epoch, packet.flags & FLAG_ANEW
        if avatar != self._avatar:
            self._avatar, self._reference = avatar, None
        self._packet, self._fresh, self._avatar_x = packet, True, packet.position
        if packet.echo_seq in self._sent:
            self._time(packet)

    def _time(self, packet: WavePacket) -> None:
        """Note how long a wave goes around: filter, packets that are not answered, hold."""
        now = self._waiting_s(packet) + packet.period + self._hold_s
        ratio = packet.period / SMOOTHED_S if truth(self.round_trip_s > 0.0) else 1.0
        self.round_trip_s = self.round_trip_s + min(ratio, 1.0) * (now - self.round_trip_s)

    def _waiting_s(self, packet: WavePacket) -> Value:
        """Return the time of filter and packets that a packet does not answer yet [s]."""
        frames = self._newest - packet.echo_seq
        return self._filter_s + 0.5 * self._frame_s + frames * self._frame_s

    def step(self, x: Value, v: Value) -> Value:
        """Return what is to be corrected, for the device at x; v is the hold's wave of the tick.

        Once a tick.
        """
        before, self._v = self._v, v
        packet, fresh = self._packet, self._fresh
        if packet is None:
            return 0.0
        self._fresh = False
        apart = x - self._avatar_x
        rest = None
        if fresh and packet.echo_seq in self._sent:
            rest = apart - self._lag(packet, before)
            if self._reference is None:
                self._reference = rest
        if self._reference is None:
            return 0.0
        return self._chosen(apart, rest, self._reference)

    def _chosen(self, apart: Value, rest: Value | None, reference: Value) -> Value:
        return apart - reference

    def _lag(self, packet: WavePacket, v: Value) -> Value:
        """Return what the waves on their way explain [m]; v is that of the last tick."""
        up = self._filter_s * self._y + self._since
        up = up + (self._integral - self._sent[packet.echo_seq])
        down = packet.wave * packet.period + self._hold_s * v
        lag: Value = (up - down) / self.scale
        return lag


class PositionResidual(PositionError):
    """The error that no wave in flight explains [m]: set by each packet, kept for its frame.

    Zero after a frame that brought no packet: nothing is known then.
    """

    SIGNALS = "_residual"
    MEMORY = "_left"

    def __init__(self, params: MasterParams) -> None:
        super().__init__(params)
        self._ticks = params.rate_drop
        self._residual: Value = 0.0
        self._left = 0

    def _chosen(self, apart: Value, rest: Value | None, reference: Value) -> Value:
        if rest is not None:
            self._residual, self._left = rest - reference, self._ticks
        self._left -= 1
        return self._residual if self._left >= 0 else 0.0 * apart
