# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy that a master has taken in and not given out, as far as it is free to be spent.

Packets (with the energy their sender reports as sent so far, lost ones included) and the hand
bring energy in; packets take it out. Energy that filter and hold may still give out is not free::

    free = [packets received - |v|^2 T_c/2 of the ticks - T_c (M-1)/4 |v|^2]     hold, per packet
         + [|u|^2 T_c/2 of the ticks - packets sent - tau |y|^2/2]            filter, at each send
         + min(0, F xd of the device less the energy into the link)           filters, limits
         + storage declared - spent - discarded

with v the wave that the hold gives out, u the one that comes back from the device, y the filter's
output, tau its group delay less (M-1)/2 T_c: the wave that is in the filter when a packet has just
been sent. The first line never falls while packets come in time. Where a hold gives out energy
that no packet brought, the tank pays; ``deficit_j`` counts the remainder, at most M T_c/2 |v|^2
for each load of a packet received before, and later packets pay that first. A packet that the tank
cannot pay for is shortened. So at every packet

    storage + received + F xd - sent >= - deficit

with any passive port filters, for any anti-aliasing filter. F xd comes from the waves: behind an
encoder it counts energy that the hand did not give. What is *spent* is bounded by the work of the
hand as well, force held times distance measured,

    spent <= storage + received + sum F_k (x_{k+1} - x_k) - sent, with the reserves above

in which an encoder errs to the safe side (docs/theory.md, section 13): a grip held between two of
its counts leaves nothing to spend. Not here: what the energy is spent on.

Equations: docs/theory.md 3.3, 9.4, 9.5, 9.6, 9.7.
"""

from pmwvc_core.master.position.lags import filter_lag_s, hold_lag_s
from pmwvc_core.numeric import Value, anywhere, dot, maximum, minimum, root, squared, where
from pmwvc_core.params import MasterParams
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.wave.affordable import affordable
from pmwvc_core.wave.ledger import EnergyLedger, PortLedger

SPREAD_S = 0.1  # time constant of giving out the tank: in one tick it would be a force step


class EnergyTank(Stateful):
    """The account of one master; it begins with the storage that the parameters declare.

    Attributes
    ----------
    saved_j
        Free but for parts and limits [J]; below zero while the reserves are not covered.
    spent_j
        Spent since the start, less what came back [J].
    deficit_j
        What the hold gave out, no packet has brought yet and nothing saved could pay [J].
    discarded_j
        What was more than the account may hold [J].
    """

    BLOCKS = "_played _taken _device"
    MEMORY = (
        "saved_j spent_j deficit_j discarded_j _work _x _f _received _reported _v _y "
        "_of_hold _of_u"
    )

    def __init__(self, params: MasterParams) -> None:
        self.saved_j: Value = params.position.storage_j
        self.spent_j: Value = 0.0
        self.deficit_j: Value = 0.0
        self.discarded_j: Value = 0.0
        self._played = EnergyLedger()  # v
        self._taken = EnergyLedger()  # u
        self._device = PortLedger()
        self._work: Value = 0.0  # of the hand, by force held and distance
        self._x: Value | None = None
        self._f: Value = 0.0
        self._received: Value = 0.0
        self._reported: tuple[int, int, Value] = (0, 0, 0.0)  # epoch, number, energy of the newest
        self._v: Value = 0.0
        self._y: Value = 0.0
        self._of_hold: Value = 0.0  # first line when it was last looked at
        self._of_u: Value = 0.0
        self.configure(params)

    def configure(self, params: MasterParams) -> None:
        """Take other parameters over; what was saved stays."""
        self._tick_s = params.tick_s
        self._frame_s = params.frame_s
        self._hold_s = hold_lag_s(params)
        self._filter_s = maximum(filter_lag_s(params), 0.0)
        self._most = params.position.most_j

    @property
    def free_j(self) -> Value:
        """Energy that may be spent now [J]."""
        by_work = self.saved_j + self.discarded_j + (self._work - self._channel())
        return maximum(minimum(self.saved_j + self._lacking(), by_work), 0.0)

    def on_packet(self, packet: WavePacket) -> None:
        """Settle the frame that ends, then take the newest packet in."""
        of_hold = self._received - self._played.energy_j - 0.5 * self._hold_s * squared(self._v)
        change = of_hold - self._of_hold
        self._of_hold = of_hold
        gained, lost = maximum(change, 0.0), maximum(-change, 0.0)
        repaid = minimum(self.deficit_j, gained)
        drawn = minimum(maximum(self.saved_j, 0.0), lost)
        self.deficit_j = self.deficit_j + (lost - drawn) - repaid
        self._save(gained - repaid - drawn)
        epoch, seq, reported = self._reported
        if packet.epoch != epoch:
            reported = packet.energy - squared(packet.wave) * (0.5 * packet.period)
        elif packet.seq <= seq:
            return
        self._received = self._received + maximum(packet.energy - reported, 0.0)
        self._reported = packet.epoch, packet.seq, packet.energy

    def move(self, x: Value) -> None:
        """Count the work of the force held until the device is at x [m]."""
        if self._x is not None:
            self._work = self._work + dot(self._f, x - self._x)
        self._x = x

    def play(self, v: Value) -> None:
        """Note what the hold gives out in a tick [sqrt(W)]."""
        self._v = v
        self._played.add(v, self._tick_s)

    def spend(self, v: Value, wanted: Value) -> Value:
        """Return as much of a change wanted of the wave v as can be paid for [sqrt(W)].

        That is the longest s w, s <= 1, with (|v + s w|^2 - |v|^2)/2 <= free/0.1 s. A change that
        makes the wave smaller brings energy.
        """
        wanted, cost = affordable(v, wanted, self.free_j * (2.0 / SPREAD_S))
        cost = cost * (0.5 * self._tick_s)
        self.spent_j = self.spent_j + cost
        self._save(-cost)
        return wanted

    def take(self, u: Value, f: Value, xd: Value) -> None:
        """Note what came back in a tick [sqrt(W)], and the device's force and velocity."""
        self._taken.add(u, self._tick_s)
        self._device.add(f, xd, self._tick_s)
        self._f = f

    def send(self, y: Value) -> Value:
        """Return the filter's output y, or as much of it as can be paid for [sqrt(W)]."""
        taken = self._taken.energy_j - self._of_u
        self._of_u = self._taken.energy_j
        before = taken + 0.5 * self._filter_s * squared(self._y)
        energy = squared(y) * (0.5 * self._frame_s)
        allowed = maximum(self.saved_j + before + self._lacking(), 0.0)
        self._y = y
        sent = y
        if anywhere(energy > allowed):
            ratio = root(minimum(allowed / where(energy > 0.0, energy, 1.0), 1.0))
            sent, energy = ratio * y, minimum(energy, allowed)
        self._save(before - 0.5 * self._filter_s * squared(y) - energy)
        return sent

    def _lacking(self) -> Value:
        """Return what parts and limits gave out more than they got [J], as a number below zero."""
        return minimum(self._device.energy_j - self._channel(), 0.0)

    def _channel(self) -> Value:
        """Return what the waves took in at the device [J]."""
        return self._taken.energy_j - self._played.energy_j - self.spent_j

    def _save(self, energy: Value) -> None:
        """Put energy [J] on the account; what is more than it may hold is gone."""
        saved = self.saved_j + energy
        self.saved_j = minimum(saved, self._most)
        self.discarded_j = self.discarded_j + (saved - self.saved_j)
