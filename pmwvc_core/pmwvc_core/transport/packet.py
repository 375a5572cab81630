# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The packet: one sample of a wave with the running sums of all samples before it.

The sums make every packet contain all earlier ones, so a receiver can see (and a strict one
repair) loss, duplication and reordering. A sample that is held back takes no number: the packet
behind it stands for the time of both. How a packet becomes a message is not known here.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from pmwvc_core.account import Passage
from pmwvc_core.numeric import Flag, Value, anywhere, squared
from pmwvc_core.state import Stateful
from pmwvc_core.transport.deadband import Deadband
from pmwvc_core.transport.verdict import Verdict

# With what is in flight; without waves of both directions together.
LINK_UP = Passage("link_up", ("u_tx",), ("u_s",))
LINK_DOWN = Passage("link_down", ("v_s",), ("v_rx",))
LINK = Passage("link", ("device",), ("server",))

FLAG_DIRECT = 1  # no wave: a velocity (up), a force or a position (down); see ``content``
FLAG_LEAVING = 2  # the last packet: the sender leaves
FLAG_LIMITED = 4  # the safety limits changed a force since the last packet
FLAG_ANEW = 8  # flips whenever the server places the user's avatar anew
FLAG_WAITING = 16  # the sender has nothing of the receiver's waves at hand (strict channel)
FLAG_SHORT = 32  # of a message: ``short``
FLAG_CHALLENGE = 64  # no wave: it asks a sender that is not followed to echo it
LAST_NUMBER = (1 << 32) - 1  # 1 follows


@dataclass(slots=True)
class WavePacket:
    """One packet; in a batch the values are ``(runs, dof)`` and the energy ``(runs, 1)``."""

    epoch: int  # random at each start of the sender
    seq: int  # 1, 2, 3...
    sent_ns: int  # the sender's monotonic clock
    period: float  # [s] one sample stands for
    wave: Value  # [sqrt(W)]
    integral: Value  # [sqrt(W) s] running sum of wave * period
    energy: Value  # [J] running sum of |wave|^2 * period / 2
    position: Value  # [m] of the sending end, for information
    echo_seq: int = 0  # newest packet of the peer: its number (0: none yet),
    echo_sent_ns: int = 0  # the peer's clock when it was sent,
    echo_hold_ns: int = 0  # and how long ago it came in here
    flags: int = 0
    session: int = 0  # number of the session, 0: an open one
    short: Flag = False  # the sender's playout lacks energy, one per run; in a message a flag
    came_ns: int = 0  # this end's clock at reception where known; no field of the message
    refusal: Verdict | None = None  # found before the receiver, which counts it; no field either

    @property
    def message_flags(self) -> int:
        """Return the flags of the message that carries it."""
        return self.flags | (FLAG_SHORT if anywhere(self.short) else 0)


def ahead(before: WavePacket, packet: WavePacket) -> int:
    """Return by how much the number of a packet is above that of another one of its sender, where
    numbers begin anew after the last one.
    """
    half = LAST_NUMBER // 2
    return (packet.seq - before.seq + half) % LAST_NUMBER - half


def refused(verdict: Verdict) -> WavePacket:
    """Return a packet whose fields cannot be trusted, for a receiver to count as this."""
    return WavePacket(0, 1, 0, 0.0, 0.0, 0.0, 0.0, 0.0, refusal=verdict)


class PacketLink(Protocol):
    """One end of a user's link, as a live loop uses it."""

    def take(self) -> Sequence[WavePacket]:
        """Return the packets that have arrived since the last call; never wait."""

    def send(self, packet: WavePacket) -> None:
        """Send a packet to the other end."""


class Packer(Stateful):
    """Number the outgoing packets of one life of a sender and keep their running sums.

    Parameters
    ----------
    epoch
        Number of this life of the sender, different from all others.
    period
        Time one sample stands for [s]; may change between two of them.
    deadband
        Decides which samples need no packet of their own; none by default.

    Attributes
    ----------
    frames
        Samples so far: packets, and those held back.
    """

    BLOCKS = "deadband"
    MEMORY = "period seq frames integral energy _flags _held_s _sent"

    def __init__(self, epoch: int, *, period: float, deadband: Deadband | None = None) -> None:
        self.epoch = epoch
        self.period = period
        self.deadband = deadband or Deadband()
        self.seq = 0
        self.frames = 0
        self.integral: Value = 0.0
        self.energy: Value = 0.0
        self._flags = 0  # of the last packet
        self._held_s = 0.0  # time of the samples held back since the last packet
        self._sent: Value = 0.0  # integral up to them

    def holds_back(self, wave: Value, flags: int = 0) -> bool:
        """Hold a sample back where the deadband says so: the next packet stands for it, too."""
        period, deadband = self.period, self.deadband
        if not deadband.on or flags != self._flags:
            return False
        if not deadband.holds_back(wave, self._held_s, period):
            return False
        if not self._held_s:
            self._sent = self.integral
        self.frames += 1
        self._held_s += period
        self._add(wave)
        return True

    def _add(self, wave: Value) -> None:
        self.integral = self.integral + wave * self.period
        self.energy = self.energy + squared(wave) * (0.5 * self.period)

    def pay(self, energy: Value) -> None:
        """Let the next packet bring more energy than its wave needs [J]."""
        self.energy = self.energy + energy

    def pack(
        self,
        wave: Value,
        position: Value,
        now_ns: int,
        flags: int = 0,
        echo: tuple[int, int, int] = (0, 0, 0),
        energy: Value | None = None,
        short: Flag = False,
    ) -> WavePacket:
        """Return the next packet.

        Parameters
        ----------
        wave
            Sample to send [sqrt(W)], float or ``(..., dof)``; with those held back before it, the
            packet carries their mean.
        position
            Position of this end [m].
        now_ns
            This end's monotonic clock.
        flags
            Bitwise or of ``FLAG_*``.
        echo
            Result of :meth:`Receiver.echo` for the peer's newest packet.
        energy
            Running sum that a controller keeps itself [J]; by default that of the waves sent.
        short
            Whether the playout of this end lacks energy, one per run.
        """
        period = self.period
        self.seq = seq = self.seq % LAST_NUMBER + 1
        self.frames += 1
        self._flags = flags
        self._add(wave)
        if self._held_s:
            period += self._held_s
            wave = (self.integral - self._sent) * (1.0 / period)
            self._held_s = 0.0
        self.deadband.sent(wave)
        echo_seq, echo_sent_ns, echo_hold_ns = echo
        return WavePacket(
            self.epoch,
            seq,
            now_ns,
            period,
            wave,
            self.integral,
            self.energy if energy is None else energy,
            position,
            echo_seq,
            echo_sent_ns,
            echo_hold_ns,
            flags,
            short=short,
        )


def size_bytes(dof: int) -> int:
    """Return the size of a serialized Wave message (CDR): 124 bytes and three values per axis."""
    return 124 + 24 * dof
