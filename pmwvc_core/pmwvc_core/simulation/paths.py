# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One direction of one user's network in virtual time: link and receiver, for one run or a batch.

In a batch every distinct link (settings and seed) exists once and serves the runs that share it:
runs that are compared under the same network meet the same packet fates.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.network.link import Fate, Link, stream_of
from pmwvc_core.numeric import Array, Flag, Value
from pmwvc_core.params import LinkParams
from pmwvc_core.wave.packet import WavePacket, size_bytes
from pmwvc_core.wave.receiver import Receiver

Members = NDArray[np.intp] | None  # the runs a link serves; None: all of them


@dataclasses.dataclass
class Lane:
    """One link, its receiver, the runs it serves, and what passed."""

    link: Link
    receiver: Receiver
    members: Members
    fates: list[Fate] = dataclasses.field(default_factory=list)
    arrived: list[tuple[int, int]] = dataclasses.field(default_factory=list)  # (seq, time_ns)


class Path:
    """Everything between one sender and its receiver; also the receiver's :class:`Inbox`."""

    def __init__(
        self,
        params: Sequence[LinkParams],
        seeds: Sequence[int],
        *,
        user: int,
        direction: int,
        period_s: float,
        timeout_s: float,
        dof: int,
    ) -> None:
        self.runs = len(params)
        self.dof = dof
        self.size_bytes = size_bytes(dof)
        self.sent: list[WavePacket] = []
        keys = list(zip(params, seeds, strict=True))
        distinct = list(dict.fromkeys(keys))
        self.lanes = [
            Lane(
                Link(link, seed=stream_of(seed, user, direction)),
                Receiver(dof, period_s=period_s, timeout_s=timeout_s),
                None
                if len(distinct) == 1
                else np.array([i for i, key in enumerate(keys) if key == (link, seed)]),
            )
            for link, seed in distinct
        ]

    def send(self, packet: WavePacket, now_ns: int) -> None:
        """Give a packet to every lane."""
        self.sent.append(packet)
        for lane in self.lanes:
            part = packet if lane.members is None else _part(packet, lane.members)
            lane.fates += lane.link.send(part, now_ns, size_bytes=self.size_bytes)

    def collect(self, now_ns: int) -> None:
        """Hand everything that has arrived by now to the receivers."""
        for lane in self.lanes:
            for packet, _ in lane.link.arrivals(now_ns):
                lane.receiver.push(packet, now_ns)
                lane.arrived.append((packet.seq, now_ns))

    def take(self, now_ns: int) -> Value:
        """Return the newest wave of every run."""
        if self.lanes[0].members is None:
            return self.lanes[0].receiver.take(now_ns)
        return self._joined([lane.receiver.take(now_ns) for lane in self.lanes], self.dof)

    def position(self) -> Value:
        """Return the position that came with it."""
        if self.lanes[0].members is None:
            return self.lanes[0].receiver.position()
        return self._joined([lane.receiver.position() for lane in self.lanes], self.dof)

    def silent(self, now_ns: int) -> Flag:
        """Tell per run whether the other end has been silent for too long."""
        if self.lanes[0].members is None:
            return self.lanes[0].receiver.silent(now_ns)
        return self._joined([lane.receiver.silent(now_ns) for lane in self.lanes], 1) > 0.0

    def silence_s(self, now_ns: int) -> Value:
        """Return per run the time since the last accepted packet [s]."""
        if self.lanes[0].members is None:
            return self.lanes[0].receiver.silence_s(now_ns)
        return self._joined([lane.receiver.silence_s(now_ns) for lane in self.lanes], 1)

    def heard(self) -> Flag:
        """Tell per run whether any packet was ever accepted."""
        if self.lanes[0].members is None:
            return self.lanes[0].receiver.heard()
        return self._joined([lane.receiver.heard() for lane in self.lanes], 1) > 0.0

    def echo(self, now_ns: int) -> tuple[int, int, int]:
        """Return the echo of the first lane: virtual clocks are one clock."""
        return self.lanes[0].receiver.echo(now_ns)

    def lane_of(self, run: int) -> Lane:
        """Return the lane that serves a run."""
        return next(lane for lane in self.lanes if lane.members is None or run in lane.members)

    def _joined(self, values: Sequence[Value], width: int) -> Array:
        whole = np.empty((self.runs, width))
        for lane, value in zip(self.lanes, values, strict=True):
            whole[lane.members] = value
        return whole


def _part(packet: WavePacket, members: NDArray[np.intp]) -> WavePacket:
    """Return the packet as the given runs sent it."""

    def of(value: Value) -> Value:
        return value[members] if isinstance(value, np.ndarray) else value

    return dataclasses.replace(
        packet,
        wave=of(packet.wave),
        integral=of(packet.integral),
        energy=of(packet.energy),
        position=of(packet.position),
    )
