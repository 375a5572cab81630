# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The conditions of a session in virtual time: its links, each from the sender's log to the
receiver, with the traces of packets on both sides, of their fates and receptions; and what its
scenario does not name: phases of a frame, recorded fates, the force of a hand, the times at which
loops ran.
"""

from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.ends.inbox import vector
from pmwvc_core.frame import AT_ONCE, FrameSchedule
from pmwvc_core.network.in_flight import Cause, Fate, RecordedLink
from pmwvc_core.network.link import Link
from pmwvc_core.numeric import Array, Integers, Value
from pmwvc_core.params import LinkParams
from pmwvc_core.plant.hand import Place
from pmwvc_core.plant.hands import Made
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import FateTraces, PacketTraces, ReceptionTraces, SessionTraces, TakenTraces
from pmwvc_core.transport.packet import Receipt, WavePacket, refused, size_bytes
from pmwvc_core.transport.receiver import Receiver, counts, passage


class SimulatedLink:
    """Everything between a sender and its receiver, with the record of what passed."""

    def __init__(self, link: Link | RecordedLink, receiver: Receiver, dof: int) -> None:
        self.link, self.receiver = link, receiver
        self.sent: list[WavePacket] = []
        self.arrived: list[tuple[WavePacket, int]] = []  # packet, time [ns]
        self.taken = 0  # of them by the receiver
        self.fates: list[Fate] = []
        self._dof, self._size_bytes = dof, size_bytes(dof)

    def configure(self, params: LinkParams) -> None:
        """Take other settings over; a link as recorded stays as it is."""
        if isinstance(self.link, Link):
            self.link.configure(params)

    def send(self, packet: WavePacket, now_ns: int) -> None:
        """Give a packet to the link."""
        self.sent.append(packet)
        size = self._size_bytes + 8 * len(packet.extra)
        self.fates += self.link.send(packet, now_ns, size_bytes=size)

    def collect(self, now_ns: int) -> list[WavePacket]:
        """Return what has arrived by now, in the order of arrival."""
        packets = []
        for packet, fate in self.link.arrivals(now_ns):
            corrupted = fate.cause is Cause.CORRUPTION
            packets.append(refused(Receipt.CORRUPTED) if corrupted else packet)
            self.arrived += [] if corrupted else [(packet, now_ns)]
        self.taken = len(self.arrived)
        return packets

    def drain(self, end_ns: int) -> None:
        """Note what came out before the end of the session but was not looked at any more."""
        for packet, fate in self.link.arrivals(end_ns - 1):
            if fate.cause is not Cause.CORRUPTION:
                self.arrived.append((packet, fate.time_due_ns))

    def traces(
        self, looks_ns: Sequence[int]
    ) -> tuple[FateTraces, ReceptionTraces, TakenTraces, list[PacketTraces]]:
        """Return fates, counts, packets taken in at looks [ns], and packets on both sides."""
        fates, arrived, nameless = self.fates, self.arrived[: self.taken], ""
        rows = [(f.number, f.size, f.time_in_ns, f.time_due_ns, f.kind, f.cause) for f in fates]
        of_fates = np.array(rows, dtype=np.int64).reshape(-1, 6).T.copy()
        number, size_bytes, time_in_ns, due_ns, kind, cause = of_fates
        epochs = np.full(len(fates), self.sent[0].epoch if self.sent else 0, dtype=np.uint64)
        numbers, times_ns = (number, epochs, number.copy()), (time_in_ns, due_ns, due_ns.copy())
        came = np.array([(each.seq, each.epoch, ns) for each, ns in arrived], dtype=np.int64)
        seq, epoch, at_ns = came.reshape(-1, 3).T.copy()
        counted, passed = counts(self.receiver), passage(self.receiver.path.estimate())
        sent = [(packet, packet.sent_ns) for packet in self.sent]
        return (
            FateTraces(nameless, *numbers, size_bytes, *times_ns, kind, cause),
            ReceptionTraces(nameless, receivers=1, counts=counted, passage=passed),
            TakenTraces(np.searchsorted(np.array(looks_ns), at_ns), seq, epoch & 0xFFFFFFFF),
            [_packets(seen, self._dof) for seen in (sent, self.arrived)],
        )


def add_link(
    traces: SessionTraces, user: str, way: str, fates: FateTraces, reception: ReceptionTraces,
    taken: TakenTraces, packets: Sequence[PacketTraces],
) -> None:  # fmt: skip
    """Add the traces of a user's link, up or down, to those of a session, by their names."""
    name, sides = f"{user}/{way}", (f"/{user}", f"/server/{user}")
    traces.fates[name] = replace(fates, link=name)
    traces.receptions[name] = replace(reception, link=name)
    traces.taken[name] = taken
    for side, seen in zip(sides if way == "up" else sides[::-1], packets, strict=True):
        topic = f"{side}/wave_{way}"
        traces.packets[topic] = replace(seen, topic=topic)
        traces.counts[topic] = {"messages": len(seen.seq), "missing": 0}


def _packets(seen: Sequence[tuple[WavePacket, int]], dof: int) -> PacketTraces:
    """Return packets, with the times at which they were seen [ns]."""
    times_s = np.array([time_ns for _, time_ns in seen], dtype=float) * 1e-9

    def each(name: str, kind: type = float) -> NDArray[Any]:
        return np.array([getattr(packet, name) for packet, _ in seen], dtype=kind)

    numbers = each("epoch", np.uint64), each("seq", np.int64), each("sent_ns", np.int64)
    wave, integral, energy, position = (
        columns((getattr(packet, name) for packet, _ in seen), axes)
        for name, axes in (("wave", dof), ("integral", dof), ("energy", 1), ("position", dof))
    )
    sums = wave, integral, energy[:, 0], position, each("orientation")
    return PacketTraces("", times_s, *numbers, each("period"), *sums)


def columns(values: Iterable[Value], axes: int) -> Array:
    """Return signals ``(rows, axes)``; a number stands for all axes."""
    every = [vector(value, axes) for value in values]
    return np.array(every, dtype=float).reshape(len(every), axes)


class Ticks:
    """The ticks of a user's loop that run, counted by the session, of which there are so many."""

    def __init__(self, first: int, ran_ns: Integers | None, ticks: int, tick_ns: int) -> None:
        self.count, self.first = ticks, first  # first: where the loop counts 0
        self.ran: Sequence[int] = range(first, ticks)
        self.at_ns: Sequence[int] = range(first * tick_ns, ticks * tick_ns, tick_ns)
        if ran_ns is not None:
            self.ran = [n for n in np.flatnonzero(ran_ns[:ticks] >= 0).tolist() if n >= first]
            self.at_ns = ran_ns[self.ran].tolist()
        self.next = 0  # of them
        self._reached = self.ran[0] if self.ran else 0  # before it all have run or passed

    def passing(self, most: int) -> range:
        """Return the ticks that pass before the next that runs, fewer than ``most``; told once."""
        begin, self._reached = self._reached, self.ran[self.next]
        return range(begin, min(self._reached, begin + most - 1))

    def take(self, before_ns: int, ends: int) -> tuple[slice, bool]:
        """Take a frame's ticks before an instant [ns] that run one after the other; return also
        whether they are its last.
        """
        begin, number = self.next, self.ran[self.next]
        after = bisect_left(self.at_ns, before_ns, begin)
        after = bisect_left(self.ran, ends, begin, after)
        while self.ran[after - 1] - number != after - 1 - begin:  # behind a gap
            after -= 1
        self.next, self._reached = after, self.ran[after - 1] + 1
        return slice(begin, after), after == len(self.ran) or self.ran[after] >= ends


class Steps(NamedTuple):
    """The server's steps ``(steps,)``: tick, when it ran [ns], and length [s] of each."""

    tick: Integers
    ran_ns: Integers
    period_s: Array


@dataclass(frozen=True)
class Conditions:
    """Conditions by name of user or link; whatever is not named stays simulated.

    ``schedule`` has the phases of a frame: with an answer later than its start masters take
    packets in at every tick, as live. A user's loop counts 0 at the tick ``first`` of the session;
    ``ran_ns`` is when each of its ticks ran, negative where it did not ``(ticks,)``. ``links``
    makes the link of one direction, ``user1/up``; ``hands`` are state and parameters of the law of
    a user's hand.
    """

    schedule: FrameSchedule = AT_ONCE
    first: Mapping[str, int] = field(default_factory=dict)
    ran_ns: Mapping[str, Integers] = field(default_factory=dict)
    steps: Steps | None = None
    links: Mapping[str, Callable[[], RecordedLink]] = field(default_factory=dict)
    hands: Mapping[str, Made] = field(default_factory=dict)

    def link_of(
        self, scenario: Scenario, index: int, direction: int, inbox: Receiver
    ) -> SimulatedLink:
        """Return a link of the user with a number (from 0): 0 up, 1 down, to a receiver."""
        user = scenario.users[index]
        recorded = self.links.get(f"{user.name}/{('up', 'down')[direction]}")
        seed, params = (scenario.seed, index, direction), (user.link_up, user.link_down)[direction]
        link = recorded() if recorded else Link(params, seed=seed, direction=direction)
        return SimulatedLink(link, inbox, scenario.dof)


FROM_SCENARIO = Conditions()


def place_of(user: User, scenario: Scenario) -> Place:
    """Return where a user's hand is: its device starts in front of its face of the object."""
    half_m = scenario.server.object_size_m / 2
    start_m = user.side * (half_m + user.contact.gap_m)
    return Place(user.side, half_m, start_m, scenario.tick_s, scenario.dof)
