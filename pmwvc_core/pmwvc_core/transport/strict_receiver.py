# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The receiver of the strict channel: what packets add to their running sums is played out.

A packet contains all earlier ones, so the newest one is enough: the difference of two integrals
and two energies is a segment for the playout (:mod:`pmwvc_core.wave.playout`), over the time of
all packets in between. Loss joins segments, duplicates and stragglers add nothing, and packets may
stand for any time. A segment's length is counted in packets, not by the sender's clock: a sender
that wakes late has not sent another wave. Only where packets stood for different times its clock
tells, within their bounds, how long lost ones were.

What is counted follows the sums of the packets; the energy never goes back::

    U <- U + dU     dU = packet's U - U,   |dU| <= longest legal wave * time
    J <- J + dJ     dJ = packet's J - J,   0 <= dJ <= what that wave carries

The time of silence follows what packets do: three of their intervals (a longer one counts at
once), and beyond the lateness that they usually have, what the playout keeps at hand. A packet
also tells whether its sender has waves of this end at hand; both ends brake while either has not.

Equations: docs/theory.md 17.24.
"""

from typing import Any

from pmwvc_core.numeric import (
    Flag,
    Value,
    anywhere,
    limit_length,
    maximum,
    minimum,
    squared,
    where,
)
from pmwvc_core.transport.packet import FLAG_ANEW, FLAG_WAITING, WavePacket, ahead
from pmwvc_core.transport.receiver import Receiver
from pmwvc_core.wave.playout import RETURN_S, Playout

LONGEST_PERIOD_S = 10.0
LATENESSES = 4.0  # usual ones, until silence begins
SMOOTHED = 1.0 / 16.0  # weight of a packet in interval and lateness


class StrictReceiver(Receiver):
    """The receiving end of one direction of the strict channel; see the module.

    Parameters
    ----------
    dof, period_s, timeout_s, max_wave
        As for every receiver; the period is the one expected at first.
    most_repaid, rises_s
        Longest wave that makes up what is undelivered [sqrt(W)], and the time in which it grows to
        that [s].
    store_j
        Initial stored energy of the playout [J].

    Attributes
    ----------
    interval_s, lateness_s
        Time for which packets stand, and mean deviation of their arrivals from it [s].
    """

    MEMORY = "interval_s lateness_s _silence_ns _least_s _most_s _unreceived_ns"
    plays_on = True
    playout: Playout

    def __init__(
        self,
        dof: int,
        *,
        most_repaid: Value,
        timeout_s: float,
        rises_s: float = RETURN_S,
        store_j: Value = 0.0,
        **as_any_receiver: Any,
    ) -> None:
        super().__init__(dof, timeout_s=timeout_s, **as_any_receiver)
        self.playout = Playout(most_repaid=most_repaid, rises_s=rises_s, store_j=store_j)
        self.interval_s = self.period_s
        self.lateness_s = 0.0
        self._unreceived_ns: int | None = None  # since when the other end waits
        self._least_silence_s = timeout_s
        self._least_s = self._most_s = self.period_s  # for which packets stood

    def waits(self, now_ns: int) -> tuple[Flag, bool]:
        """Tell whether this end brakes, since it or the other one has been without waves for too
        long; and whether the other end has.
        """
        begun_ns = self._unreceived_ns
        unreceived = begun_ns is not None and now_ns - begun_ns > self._silence_ns
        return unreceived or self.playout.pace.brakes, unreceived

    def _lasts(self, period_s: float) -> bool:
        return 0.0 < period_s <= LONGEST_PERIOD_S

    def _accept(self, packet: WavePacket, now_ns: int, *, fresh: bool) -> None:
        before, came_ns = self.newest, self.accepted_ns
        super()._accept(packet, now_ns, fresh=fresh)
        if not packet.flags & FLAG_WAITING:
            self._unreceived_ns = None
        elif self._unreceived_ns is None:
            self._unreceived_ns = now_ns
        if fresh or before is None:  # what it sent before it was followed does not count
            self._begin(packet, 0.0)
            return
        passed_s = (now_ns - came_ns) * 1e-9
        lasted_s = min(self._lasted_s(before, packet), passed_s + LONGEST_PERIOD_S)
        moved, paid_j = self._counted(before, packet, lasted_s)
        if (packet.flags ^ before.flags) & FLAG_ANEW:
            self._begin(packet, paid_j)
            return
        self.playout.add(moved, paid_j, lasted_s)
        late_s = abs(passed_s - lasted_s)
        self.lateness_s += SMOOTHED * (late_s - self.lateness_s)
        smoothed_s = self.interval_s + SMOOTHED * (packet.period - self.interval_s)
        self.interval_s = max(smoothed_s, packet.period)
        usual_s = 3.0 * self.interval_s + LATENESSES * self.lateness_s
        self._silence_ns = round(max(self._least_silence_s, usual_s) * 1e9)

    def _begin(self, packet: WavePacket, paid_j: Value) -> None:
        """Begin with the wave of this packet alone, and what it needs of the energy paid [J]."""
        self.playout.begin()
        own_j = minimum(squared(packet.wave) * (0.5 * packet.period), paid_j)
        self.playout.add(packet.wave * packet.period, own_j, packet.period)
        self._least_s = self._most_s = packet.period

    def _counted(
        self, before: WavePacket, packet: WavePacket, lasted_s: float
    ) -> tuple[Value, Value]:
        """Return displacement [sqrt(W) s] and energy [J] that a packet adds to those counted; its
        sums become what is counted with it.
        """
        moved, longest = packet.integral - before.integral, self.max_wave * lasted_s
        far = squared(moved) > longest**2
        if anywhere(far):
            moved = where(far, limit_length(moved, longest), moved)
            packet.integral = before.integral + moved
        claimed_j = packet.energy - before.energy
        paid_j = minimum(maximum(claimed_j, 0.0), 0.5 * self.max_wave**2 * lasted_s)
        if anywhere(paid_j != claimed_j):
            packet.energy = before.energy + paid_j
        return moved, paid_j

    def _lasted_s(self, before: WavePacket, packet: WavePacket) -> float:
        """Return the time for which a packet stands, with those lost before it [s]."""
        period_s, lost = packet.period, ahead(before, packet) - 1
        self._least_s, self._most_s = min(self._least_s, period_s), max(self._most_s, period_s)
        if lost <= 0:
            return period_s
        sent_s = (packet.sent_ns - before.sent_ns) * 1e-9
        return period_s + min(max(sent_s - period_s, lost * self._least_s), lost * self._most_s)
