# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback on the strict channel: v_m - K_p e, paid out of the node.

The node that pays for packets (:mod:`pmwvc_core.master.strict_port`) pays for this as well: what
v_m brings less energy than the playout gave is missing from it. It begins with the energy declared
as lent, E0, and is filled up to it again from whatever comes in beyond what packets need, before
packets get it. A tick takes at most what is free, spread over ``SPREAD_S``: in one tick it would
be a force step. Motion that playouts hold or have not delivered is part of e, so that after an
outage device and avatar come together.

A packet tells where the avatar is once a step; in between e follows a line from packet to packet,
else it would have the steps of the server in it.

In free motion e is the delay of the link, x_m - x_s = v T, which nothing should correct: to do so
would add mass and damping. So e counts as far as the avatar feels a force F, in full from
``FORCE_N`` on. F follows from the packets: the wave that the server sent in its steps and the way
that the avatar went in them.

A gain that adapts is larger by up to ``MOST`` where less is left of the loan. At the wall of
stiffness K a larger gain makes slow presses give back more than they take (17.17), so what
presses have taken comes back, up to the stiffness for which ``MOST`` is enough.

Equations: docs/theory.md 17.8, 17.16.
"""

import dataclasses
from collections.abc import Mapping

from pmwvc_core.master.position.correction import SPENT, PositionCorrection
from pmwvc_core.master.position.energy_tank import SPREAD_S
from pmwvc_core.master.position.error import KEPT, PositionError, PositionResidual
from pmwvc_core.numeric import Value, anywhere, maximum, minimum, squared, where
from pmwvc_core.params import FilterParams, MasterParams
from pmwvc_core.transport.packet import WavePacket, ahead
from pmwvc_core.wave.affordable import affordable
from pmwvc_core.wave.playout import Playout

MOST = 2.0  # times the gain, with less left than a share of the loan
FULL, LEAST = 0.75, 0.25  # shares of the loan: the gain itself is used above, MOST times it below
FORCE_N = 0.05  # at the avatar: the whole error counts; below it the square of the ratio of it


class _Played(PositionError):
    """The position error under force, with the playout in place of filter and hold, and packets
    that stand for any time.
    """

    SIGNALS = "_line"
    MEMORY = "_frame_s _time_s _times_s _left_s _share _under"

    def __init__(self, params: MasterParams, playout: Playout) -> None:
        self._playout = playout
        self._line: Value = 0.0  # the avatar's position on the line to the newest packet's [m]
        self._left_s = 0.0  # until it is there
        self._under: Value = 0.0  # share of the error that counts, by the newest packet's force
        self._share: Value = 0.0  # likewise, on the line to it
        self._time_s = 0.0  # that the packets so far stand for
        self._times_s: dict[int, float] = {}  # up to each of them
        super().__init__(params)

    def configure(self, params: MasterParams) -> None:
        super().configure(dataclasses.replace(params, hold="zoh", filter=FilterParams()))

    def lasts(self, frame_s: float, seq: int) -> None:
        """Note the length of the frame [s] that goes with packet number ``seq``, perhaps with
        others.
        """
        self._frame_s = frame_s
        self._time_s += frame_s
        self._times_s[seq] = self._time_s
        self._times_s.pop(seq - KEPT, None)

    def on_packet(self, packet: WavePacket) -> None:
        avatar, before = self._avatar, self._packet
        super().on_packet(packet)
        if before is None or self._avatar != avatar:
            self._line = self._avatar_x
        elif self._packet is not before:
            self._left_s = packet.period
            way = self.scale * (packet.position - before.position)
            wave = 2.0 * (packet.integral - before.integral)
            lasted_s = ahead(before, packet) * packet.period
            force = (way - wave) * (0.5 * self.scale / lasted_s)
            self._under = minimum(squared(force) * FORCE_N**-2, 1.0)

    def step(self, x: Value, v: Value) -> Value:
        if self._left_s > 0.0:
            ratio = min(self._tick_s / self._left_s, 1.0)
            self._line = self._line + ratio * (self._avatar_x - self._line)
            self._share = self._share + ratio * (self._under - self._share)
            self._left_s = self._left_s - self._tick_s
        return super().step(x, v)

    def _chosen(self, apart: Value, rest: Value | None, reference: Value) -> Value:
        error = super()._chosen(apart + (self._avatar_x - self._line), rest, reference)
        return self._share * error

    def _waiting_s(self, packet: WavePacket) -> Value:
        return 0.5 * self._frame_s + self._time_s - self._times_s[packet.echo_seq]

    def _lag(self, packet: WavePacket, v: Value) -> Value:
        up = self._since + (self._integral - self._sent[packet.echo_seq])
        lag: Value = (up - self._playout.waiting) / self.scale
        return lag


class _PlayedResidual(_Played, PositionResidual):
    """The part of the residual that no wave in flight or in a playout explains."""


class StrictPosition(PositionCorrection):
    """See the module.

    Attributes
    ----------
    stored_j
        Energy that the node holds for it [J].
    spent_j
        What it has taken so far, less what it brought [J].
    """

    MEMORY = "spent_j"

    def __init__(self, params: MasterParams, playout: Playout) -> None:
        self.spent_j: Value = 0.0
        self._played = (_PlayedResidual if params.position.of_residual else _Played)(
            params, playout
        )
        super().__init__(params, self._played)

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over; what is known stays."""
        super().configure(params)
        self.stored_j = params.position.storage_j
        self._half_s = 0.5 * params.tick_s

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energy spent [J]."""
        return {SPENT.name: self.spent_j}

    def down(self, v: Value, x: Value, free_j: Value) -> Value:
        """Return the wave for the device at ``x`` [m], with as much of the feedback as is free."""
        wanted = self.asked(v, x)
        if wanted is None:
            return v
        if self._adapts and anywhere(self.stored_j > 0.0):
            wanted = wanted * self._larger(free_j)
        power = maximum(free_j, 0.0) * (2.0 / SPREAD_S)
        wanted, cost = affordable(v, wanted, power)
        self.spent_j = self.spent_j + cost * self._half_s
        return v + wanted

    def _larger(self, free_j: Value) -> Value:
        """Return what the gain is multiplied by, given what is left of the loan [J]."""
        lent = where(self.stored_j > 0.0, self.stored_j, 1.0)
        used = (FULL - free_j / lent) * (1.0 / (FULL - LEAST))
        return 1.0 + (MOST - 1.0) * where(
            self.stored_j > 0.0, minimum(maximum(used, 0.0), 1.0), 0.0
        )

    def take(self, u: Value) -> None:
        """Note the wave of a tick that is over [sqrt(W)]."""
        self._error.take(u)

    def send(self, wave: Value, seq: int, frame_s: float) -> None:
        """Note the wave of a frame [sqrt(W)] that goes with packet number ``seq``."""
        self._played.lasts(frame_s, seq)
        self._played.send(wave, wave, seq)
