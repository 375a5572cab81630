# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One end of passive set-position modulation: a spring whose set point moves only as far as the
energy in hand pays for (Lee and Huang 2010).

With x where this end is and q the set point, the spring K |x - q|^2/2 gains, when q moves to q',

    dE = K/2 (|x - q'|^2 - |x - q|^2)

This comes out of a tank; q' is the point nearest to the wanted one on the straight way there that
the tank can pay for. The tank is filled by what the damper of this end turns to heat, and by what
the peer sends; above a cap the rest goes to the peer.

Lee and Huang bound the damper's heat from below by positions, b (x_max - x_min)^2/dt. Here the
work done at the port in a tick is known: what has been put in and is not in the spring went to the
damper. For one tick and b = B - K dt/2 that is their bound, but for the acceleration within the
tick; it stays right where safety changes the force. Work, tank and spring add up::

    work put in + received = spring + (tank - initial) + sent + dropped

A tank below zero (a force that safety changed, a spring too stiff for its tick) moves the set
point only where that pays the tank back. Not here: where this end is, and its damper.
"""

from pmwvc_core.baselines.arrivals import Arrivals
from pmwvc_core.numeric import Value, clip, dot, maximum, root, squared, where
from pmwvc_core.params.baselines import PspmParams
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import WavePacket


class ModulatedSpring(Stateful):
    """Set point, tank and shuffled sum of one end; parameters may be ``(runs, 1)``."""

    BLOCKS = "_arrivals"
    SIGNALS = "q"
    MEMORY = "tank spring sent received dropped"

    def __init__(self, params: PspmParams) -> None:
        self._stiffness = params.stiffness
        self._cap = params.cap_j
        self.q: Value = 0.0  # [m] set point
        self.tank: Value = params.initial_j  # [J]
        self.spring: Value = 0.0  # [J]
        self.sent: Value = 0.0  # [J] running sum, goes into the packets
        self.received: Value = 0.0  # [J]
        self.dropped: Value = 0.0  # [J] springs let go
        self._arrivals = Arrivals()

    def on_packet(self, packet: WavePacket) -> None:
        """Take in what the peer sent."""
        gained = self._arrivals.take(packet)
        self.received = self.received + gained
        self.tank = self.tank + gained

    def moved(self, x: Value, work: Value) -> None:
        """Take note that this end came to x [m] while this work was put in at its port [J]."""
        spring = 0.5 * self._stiffness * squared(x - self.q)
        self.tank = self.tank + work - (spring - self.spring)
        self.spring = spring

    def aim(self, wanted: Value, x: Value) -> None:
        """Move the set point towards a wanted one [m], as far as the tank allows.

        The ratio s of the way w costs K/2 (s^2 |w|^2 - 2 s w . (x - q)).
        """
        way, stretch = wanted - self.q, x - self.q
        length, along = squared(way), dot(way, stretch)
        within = maximum(along * along + 2.0 * length * self.tank / self._stiffness, 0.0)
        ratio = clip((along + root(within)) / where(length > 0.0, length, 1.0), 0.0, 1.0)
        self.q = self.q + ratio * way
        spring = 0.5 * self._stiffness * squared(x - self.q)
        self.tank = self.tank - (spring - self.spring)
        self.spring = spring

    def divide(self) -> None:
        """Send the peer what is above the cap."""
        excess = maximum(self.tank - self._cap, 0.0)
        self.tank = self.tank - excess
        self.sent = self.sent + excess

    def let_go(self, x: Value) -> None:
        """Put the set point where this end is; what the spring holds is dropped."""
        self.q = x
        self.dropped = self.dropped + self.spring
        self.spring = 0.0 * self.spring
