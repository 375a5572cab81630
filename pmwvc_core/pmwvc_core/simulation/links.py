# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One direction of one user's network in virtual time: sender's log, link and receiver."""

from collections.abc import Callable, Mapping, Sequence

from pmwvc_core.network.in_flight import Cause, Fate, RecordedLink
from pmwvc_core.network.link import Link, stream_of
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.transport.packet import Verdict, WavePacket, refused, size_bytes
from pmwvc_core.transport.receiver import Receiver


class SimulatedLink:
    """Everything between a sender and its receiver, with the record of what passed.

    Parameters
    ----------
    link, seed
        Settings of the link and its random stream; or the link itself, as recorded.
    inbox
        The receiver at its end.
    direction
        0: from user to server, 1: back.
    """

    def __init__(
        self,
        link: LinkParams | RecordedLink,
        *,
        seed: Sequence[int],
        inbox: Receiver,
        dof: int,
        direction: int,
    ) -> None:
        self.link = (
            link if isinstance(link, RecordedLink) else Link(link, seed=seed, direction=direction)
        )
        self.receiver = inbox
        self.sent: list[WavePacket] = []
        self.arrived: list[tuple[WavePacket, int]] = []  # packet, time [ns]
        self.taken = 0  # of them by the receiver
        self.fates: list[Fate] = []
        self._size_bytes = size_bytes(dof)

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
            if fate.cause is Cause.CORRUPTION:
                packets.append(refused(Verdict.CORRUPTED))
                continue
            packets.append(packet)
            self.arrived.append((packet, now_ns))
        self.taken = len(self.arrived)
        return packets

    def drain(self, end_ns: int) -> None:
        """Note what came out before the end of the session but was not looked at any more."""
        for packet, fate in self.link.arrivals(end_ns - 1):
            if fate.cause is not Cause.CORRUPTION:
                self.arrived.append((packet, fate.time_due_ns))


def links_of(
    scenario: Scenario,
    index: int,
    ends: tuple[Receiver, Receiver],
    recorded: Mapping[str, Callable[[], RecordedLink]],
) -> tuple[SimulatedLink, SimulatedLink]:
    """Return the links up and down of the user with a number (from 0), to a receiver each;
    ``recorded`` makes those that are to be as recorded, by name: ``user1/up``.
    """
    user = scenario.users[index]

    def one(direction: int, name: str, params: LinkParams) -> SimulatedLink:
        make = recorded.get(f"{user.name}/{name}")
        return SimulatedLink(
            make() if make else params,
            seed=stream_of(scenario.seed, index, direction),
            inbox=ends[direction],
            dof=scenario.dof,
            direction=direction,
        )

    return one(0, "up", user.link_up), one(1, "down", user.link_down)
