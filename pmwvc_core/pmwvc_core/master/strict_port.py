# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of the strict channel: displacement exact, energy as far as the hand gives it.

Per tick of length h, with F the force really applied and dx the motion really measured over it::

    v     of the playout, every tick
    F_m = b xd - sqrt(2b) v_m                  asked of the device
    u   = sqrt(2b) dx/h - v_m                  known when the tick is over;   U <- U + u h
                                               (u_m is its estimate, sqrt(2b) xd - v_m)
    node <- node + |v|^2 h/2 + F dx            what came in from both sides (dx: ``counts.moved``)

and per packet, for the mean wave w of its frame::

    paid  = all of the node but KEPT_J, and of that what w needs, |w|^2 T/2
            (never what the brake stores: the hand can have it back)
    J <- J + paid,   node <- node - paid

So the energy J sent never exceeds what channel and hand gave, whatever safety limits, velocity
estimate, encoder, port filters or a late tick made of force and wave: they delay the payment, not
the displacement U + V = sqrt(2b) x. Where a force that went on pushing out took the node itself
below ``-LIMIT_J``, v waits until the hand has paid: the port is a damper. The packet carries w: no
anti-aliasing filter, which passivity does not need here.

Behind an encoder whose differences are the velocity, packets always lack some energy. Their
deficit counts twice (``TWICE``), since to make the displacement up takes as much again, and the
hand pays it by moving: F_m gets up to ``MORE`` of b xd on top, all of it from ``MUCH_J`` on.

Where one of the playouts is short of energy, after outages or with a lag that has grown, the other
one's surplus goes to it, and the hand pays likewise, through ``ASKED`` of b xd: packets take it to
the playout of the server, which returns what it does not need. Motion that no force paid for, as
that of a device that was silent, is undelivered there, too: up to all of b xd from ``MUCH`` on.

Not here: limits (``safety``), packets, time.

Equations: docs/theory.md 17.4, 17.5, 17.10, 17.23.
"""

from collections.abc import Mapping

from pmwvc_core.master.brake import HandBrake
from pmwvc_core.master.counts import BetweenCounts
from pmwvc_core.master.device_port import DevicePort
from pmwvc_core.master.position.strict import StrictPosition
from pmwvc_core.master.strict_accounts import DISCARDED, FREE, GIVEN, NODE, RELEASED
from pmwvc_core.numeric import Flag, Value, anywhere, dot, maximum, minimum, root, squared, where
from pmwvc_core.params import MasterParams
from pmwvc_core.transport.packet import Packer, WavePacket
from pmwvc_core.wave.playout import Playout

KEPT_J = 1e-4  # at the node where a packet does not need it: a tick is paid for when it is over
LIMIT_J = 2e-3
MORE = 0.3  # of the damper b, while packets lack energy
ASKED = 0.2  # likewise, while a playout is short of energy
MUCH = 0.03  # [sqrt(W) s] that packets were not paid for: all of b is asked for
MUCH_J = 1e-3
MOST_DEFICIT_J = 0.01
TWICE = 2.0
WITHHELD = 1.0  # of b q^2/h: so far ahead of the true work the one counted may be at first
SPARED_J = 1e-3  # left to the playout for catching up when the node takes what is free there


class StrictMaster(DevicePort):
    """The wave port of a device on the strict channel; see the module.

    Parameters
    ----------
    params
        Impedance, tick, rate drop, and what stands around the port; anti-aliasing filter and hold
        have no part here.
    playout
        Of the returning wave; its receiver feeds it.
    packer
        Of the outgoing wave: number of the next packet, length of the frame that ends.
    brake
        Of the device, which the safety limits step: what it stores stays at the node.

    Attributes
    ----------
    node_j
        Energy that came in from both sides and is not paid to a packet yet [J].
    deficit_j
        Energy that packets needed and have not been paid with yet [J].
    """

    BLOCKS = "tracker _position"
    SIGNALS = "_integral v_m _xd"
    MEMORY = (
        "node_j deficit_j energy_u_m energy_u_tx energy_v_m _due_j _v _f _withheld_j _settled "
        "_begun _wanted _short _unpaid"
    )

    def __init__(
        self, params: MasterParams, playout: Playout, packer: Packer, brake: HandBrake
    ) -> None:
        super().__init__(params)
        self._packer = packer
        self._brake = brake
        self._position = StrictPosition(params, playout) if params.position.is_on else None
        self.node_j: Value = self._position.stored_j if self._position else 0.0
        self.deficit_j: Value = 0.0
        self.energy_u_m: Value = 0.0
        self.energy_u_tx: Value = 0.0
        self.energy_v_m: Value = 0.0
        self._playout = playout
        self._integral: Value = 0.0  # of u since the frame began
        self._due_j: Value = 0.0  # what the next packet needs at most
        self._v: Value = 0.0  # of the playout
        self._f: Value = 0.0
        self._withheld_j: Value = 0.0
        self.tracker = BetweenCounts(params.tick_s)
        self._xd: Value = 0.0  # for the force
        self._begun = False
        self._wanted: Flag = False  # energy, at the other end
        self._short: Flag = False  # of energy: the playout here
        self._unpaid: Value = 0.0  # integral sent without its energy while the server is short
        self._settled = True  # the tick before

    def _begin_channel(self, params: MasterParams) -> None:
        self._rate = 1.0 / params.tick_s

    def _configure_position(self, params: MasterParams) -> None:
        if self._position:
            self._position.configure(params)
        elif params.position.is_on:  # what is lent it has from the start of the session or never
            self._position = StrictPosition(params, self._playout)

    @property
    def energy_v_rx(self) -> Value:
        """Energy that arrived [J]."""
        return self._playout.received_j

    @property
    def accounts(self) -> Mapping[str, Value]:
        """Energies at the node and in the playout, and those of what is around the port [J]."""
        playout = self._playout
        return {
            NODE.name: self.node_j,
            GIVEN.name: playout.given_j,
            RELEASED.name: playout.released_j,
            FREE.name: playout.free_j,
            DISCARDED.name: playout.discarded_j,
            **super().accounts,
            **(self._position.accounts if self._position else {}),
        }

    def account(self) -> Value:
        """Return the energy paid for so far [J], for the packet."""
        return self.energy_u_tx

    def on_packet(self, packet: WavePacket) -> None:
        """Note the avatar's position, and what the server lacks; the wave is the playout's."""
        ends = self._wanted & (packet.short ^ True)
        self._unpaid = where(ends, 0.0, self._unpaid)
        self._wanted, self._short = packet.short, self._playout.short
        if self._position:
            self._position.on_packet(packet)

    def receive(self, wave: Value) -> None:
        """Leave the wave to the playout."""
        if self._position:
            self._position.receive()

    def silence(self) -> None:
        """Leave the silence to the playout, which has nothing more to give out."""
        if self._position:
            self._position.silence()

    def measure(self, x: Value, xd: Value) -> None:
        """Account for the tick that ends at this position."""
        self._settle(*self._sensed(x, xd))

    def step(self, x: Value, xd: Value) -> Value:
        """Return the force wanted for the tick that starts with this motion [N]."""
        x, xd = self._sensed(x, xd)
        self._settle(x, xd)
        self._settled = False
        xd = self._xd
        v = self._playout.step(self._tick_s)
        below = self.node_j < 0.0
        if below is not False and anywhere(below):
            v = self._covered(v)
        self._v = v
        if self._position:
            v = self._position.down(v, x, self.node_j - self._due_j)
        self._held = v
        if self._port_filters:
            v = self._answered(v, xd)
        self.v_m = v
        self.u_m = self._port.u(xd, v)
        if self._velocity:
            xd = self._velocity.step(xd, self._port.b)
        f_m = self._port.force(xd, v)
        lacks, asked = self.deficit_j > 0.0, self._wanted | self._short
        if lacks is not False and anywhere(lacks):
            more = minimum(self.deficit_j * (MORE / MUCH_J), MORE)
            f_m = f_m + more * (self._port.b * self._xd)
        if asked is not False and anywhere(asked):
            more = minimum(maximum(self._unpaid * (1.0 / MUCH), ASKED), 1.0)
            f_m = f_m + where(asked, more, 0.0) * (self._port.b * self._xd)
        self.f_m = f_m
        return f_m

    def _covered(self, v: Value) -> Value:
        """Return the wave of a tick at whose start the node owes energy [sqrt(W)]: what is free in
        the playout goes to it, and where it still owes too much the wave waits.
        """
        self.node_j = self.node_j + self._playout.release(-self.node_j)
        short = self.node_j < -LIMIT_J - self._withheld_j
        if not anywhere(short):
            return v
        unused = where(short, v, 0.0)
        self._playout.take_back(unused, self._tick_s)
        return v - unused

    def applied(self, f: Value) -> None:
        """Note the force that was let through [N]; what it cost is known when the tick is over."""
        self._f = f
        self.energy_u_m = self.energy_u_m + squared(self.u_m) * self._half_s
        self.energy_v_m = self.energy_v_m + squared(self.v_m) * self._half_s

    def _settle(self, x: Value, xd: Value) -> None:
        """Account for the last tick, which ended at x [m]; once."""
        if self._settled:
            if not self._begun:
                self._x, self._xd = x, xd
                self.tracker.begin(x)
            return
        self._settled = self._begun = True
        h = self._tick_s
        self._x = x
        self._xd = self.tracker.step(x, xd)
        u = self._port.u(self.tracker.dx * self._rate, self.v_m)
        for each in self._port_filters:
            u = each.step(u)
        if self._position:
            self._position.take(u)
            self._due_j = self._due_j + squared(u) * self._half_s
        self.u_m_lp = u
        self._integral = self._integral + u * h
        self.node_j = (
            self.node_j + squared(self._v) * self._half_s + dot(self._f, self.tracker.moved)
        )

    def send(self) -> Value:
        """Return the mean wave of the frame [sqrt(W)], and pay for it."""
        frame_s, number = self._packer.period, self._packer.seq + 1
        wave = self._integral * (1.0 / frame_s)
        self._integral = 0.0 * self._integral
        needed, kept = squared(wave) * (0.5 * frame_s), KEPT_J
        lent: Value = 0.0
        if self.tracker.counts:
            self._withhold(self.tracker.rough)
        if self._position:
            lent = self._position.stored_j
            self._position.send(wave, number, frame_s)
            self._due_j = 0.0 * self._due_j
            kept = kept + lent
            short = maximum(kept - self.node_j, 0.0)
            self.node_j = self.node_j + self._playout.release(short, beyond=SPARED_J)
        self.node_j = self.node_j + self._playout.spared(frame_s, wanted=self._wanted)
        own = self.node_j - self._brake.stored_j  # what the hand can have back is not paid out
        paid = maximum(minimum(own, needed), own - kept)
        if self.tracker.counts:
            paid = maximum(paid, minimum(own - lent, needed + self.deficit_j))
        paid = maximum(paid, 0.0)
        lacks = (paid < needed) & (self._withheld_j <= 0.0)  # not for its rough counts
        if lacks is not False and anywhere(lacks):
            part = 1.0 - root(where(lacks, paid / where(lacks, needed, 1.0), 1.0))
            self._unpaid = self._unpaid + part * root(squared(wave)) * frame_s
        if self.tracker.counts:
            self._lack(needed - paid)
        self.energy_u_tx = self.energy_u_tx + paid
        self.node_j = self.node_j - paid
        return wave

    def _lack(self, short: Value) -> None:
        """Note what a packet was short of, or brought beyond its own need [J]."""
        deficit = self.deficit_j + short + (TWICE - 1.0) * maximum(short, 0.0)
        deficit = minimum(maximum(deficit, 0.0), MOST_DEFICIT_J)
        self.deficit_j = where(self._withheld_j > 0.0, deficit, 0.0)

    def _withhold(self, count: Value) -> None:
        """Keep back what the work over rough counts may be off [m]."""
        withheld = dot(self._port.b * count, count) * (WITHHELD * self._rate)
        self.node_j = self.node_j + self._withheld_j - withheld
        self._withheld_j = withheld
