# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What both ends take in: packets, which a receiver judges before the laws have them, and changes
from other threads.

Outside a signal of one axis is a float, one of several an array ``(dof,)``; in the laws both are
tuples.
"""

from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from pmwvc_core.controllers.library import has_waves, is_strict, record_of
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.vectors import Vector
from pmwvc_core.numeric import Array, Value
from pmwvc_core.transport.packet import (
    FLAG_ANEW,
    FLAG_DIRECT,
    FLAG_LEAVING,
    FLAG_SHORT,
    FLAG_WAITING,
    LEVEL_BITS,
    WavePacket,
)
from pmwvc_core.transport.receiver import ACCEPTED, NEW_EPOCH, Receiver
from pmwvc_core.wave.impedance import Impedance, largest_wave


def vector(value: Value, dof: int) -> Vector:
    """Return a signal as the laws have it; a number stands for all axes."""
    if isinstance(value, np.ndarray) and value.ndim:
        return tuple(value.tolist())
    return (float(value),) * dof


def scalar(value: Value) -> float:
    """Return a quantity of the whole (an energy), which a plug-in may give as an array of one."""
    return vector(value, 1)[0]


def value(signal: Vector | Array) -> Value:
    """Return a signal of the laws as others have it."""
    return float(signal[0]) if len(signal) == 1 else np.array(signal)


def known(packet: WavePacket, dof: int, *, fresh: bool, lost: int) -> Packet:
    """Return an accepted packet as the laws have it."""
    flags, energy_j = packet.flags, scalar(packet.energy)
    wave, integral, position = (
        vector(each, dof) for each in (packet.wave, packet.integral, packet.position)
    )
    return Packet(
        packet.seq, packet.sent_ns, packet.period, wave, integral, energy_j, position,
        bool(flags & FLAG_SHORT), bool(flags & FLAG_WAITING), bool(flags & FLAG_ANEW),
        bool(flags & FLAG_LEAVING), flags >> LEVEL_BITS, packet.extra,
        packet.echo_seq, fresh, lost, packet.epoch,
    )  # fmt: skip


def message(
    packet: Packet, epoch: int, flags: int, echo: tuple[int, int, int], orientation: Vector = ()
) -> WavePacket:
    """Return a packet of the laws for the link, with what its sender says of itself."""
    flags |= packet.waits * FLAG_WAITING | packet.anew * FLAG_ANEW | packet.leaves * FLAG_LEAVING
    return WavePacket(
        epoch, packet.number, packet.sent_ns, packet.period_s, value(packet.wave),
        value(packet.integral), packet.energy_j, value(packet.position), *echo,
        flags | packet.short * FLAG_SHORT | packet.level << LEVEL_BITS, packet.extra,
        orientation,
    )  # fmt: skip


class Inbox(Receiver):
    """The receiver at a port of some impedance [N s/m], of a session's controller and channel.
    ``other_controller`` counts packets of another kind of controller, which are ignored.
    """

    def __init__(
        self, session: Any, impedance: Impedance, *, period_s: float, timeout_s: float,
        from_server: bool,
    ) -> None:  # fmt: skip
        self._waves = has_waves(session.controller)
        super().__init__(
            session.dof, period_s=period_s, timeout_s=timeout_s,
            any_period=is_strict(session.controller, session.channel),
        )  # fmt: skip
        self.match(impedance)
        self.flags = 0 if self._waves else FLAG_DIRECT  # of packets that this end sends
        self._extra = record_of(session.controller).extra(session.dof)[from_server]
        self.other_controller = 0

    def take(self, packets: Iterable[WavePacket], now_ns: int) -> list[Packet]:
        """Return those accepted, in the order of their arrival."""
        taken = []
        for packet in packets:
            other = (packet.flags ^ self.flags) & FLAG_DIRECT or len(packet.extra) != self._extra
            if packet.refusal is None and other:
                self.other_controller += 1
                continue
            lost = self.lost
            verdict = self.push(packet, now_ns)
            if verdict is ACCEPTED or verdict is NEW_EPOCH:
                fresh = verdict is NEW_EPOCH
                taken.append(known(packet, self.dof, fresh=fresh, lost=self.lost - lost))
        return taken

    def match(self, impedance: Impedance) -> None:
        """Expect the waves of a port of another impedance [N s/m]."""
        self.max_wave = largest_wave(impedance, waves=self._waves)


class PortEnd:
    """What both ends have: a receiver per user, and changes of parameters while they run."""

    def __init__(self, inboxes: list[Inbox]) -> None:
        self.inboxes, self.changes = inboxes, 0  # frames or steps that took changes over
        self._waiting: deque[Callable[[], None]] = deque()

    @property
    def other_controller(self) -> int:
        """Packets of another kind of controller, which are ignored."""
        return sum(inbox.other_controller for inbox in self.inboxes)

    def hand_over(self, change: Callable[[], None]) -> None:
        """Have a change made at the next occasion; from any thread."""
        self._waiting.append(change)

    def _take_changes(self) -> None:
        if self._waiting:
            self.changes += 1
        while self._waiting:
            self._waiting.popleft()()
