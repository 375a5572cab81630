# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end for all users in one object: receivers, membership, the environment's step,
senders.

A user joins with its first packet (or with a new epoch: it was restarted), is rendered a matched
damper while it is silent, and leaves when it says so or stays silent for ``release_s``.
Time is an argument (integer nanoseconds of any monotonic clock).
"""

import enum
from collections.abc import Sequence
from typing import Any

from pmwvc_core.numeric import Value
from pmwvc_core.server.user_ports import ServerController
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import FLAG_ANEW, FLAG_DIRECT, FLAG_LEAVING, Packer, WavePacket
from pmwvc_core.transport.receiver import Receiver, Verdict


class Presence(enum.IntEnum):
    """What a user is to the server; the numbers are those of the ServerTrace message."""

    ABSENT = 0
    JOINING = 1
    COUPLED = 2
    DAMPING = 3


# At hand: a member is looked up in Python.
ABSENT, COUPLED, DAMPING = Presence.ABSENT, Presence.COUPLED, Presence.DAMPING
ACCEPTED, NEW_EPOCH = Verdict.ACCEPTED, Verdict.NEW_EPOCH


class Service(Stateful):
    """All users' server ports around one environment.

    Parameters
    ----------
    server
        The environment with its wave ports.
    inboxes, packers
        One receiver and one sender per user.
    release_s
        Silence after which a user is taken out [s].
    """

    BLOCKS = "server inboxes packers"
    MEMORY = "presence _anew"

    def __init__(
        self,
        server: ServerController,
        *,
        inboxes: Sequence[Receiver],
        packers: Sequence[Packer],
        release_s: float = 1.0,
    ) -> None:
        self.server = server
        self.inboxes = list(inboxes)
        self.packers = list(packers)
        self.release_s = release_s
        self.presence = [Presence.ABSENT for _ in self.inboxes]
        self._anew = [0 for _ in self.inboxes]  # FLAG_ANEW of each user's packets

    def deliver(self, user: int, packet: WavePacket, now_ns: int) -> Verdict:
        """Take one packet of a user in; a first one, or one of a new life, joins the user."""
        verdict = self.inboxes[user].push(packet, now_ns)
        if verdict is not ACCEPTED and verdict is not NEW_EPOCH:
            return verdict
        if packet.flags & FLAG_LEAVING:
            self.leave(user)
        elif verdict is NEW_EPOCH or self.presence[user] is ABSENT:
            self.join(user, packet.position)
        return verdict

    def join(self, user: int, position: Value) -> None:
        """Put a user's avatar where its device is, without a force."""
        if self.presence[user] is not Presence.ABSENT:
            self.server.leave(user)
        self.server.join(user, position)
        self._anew[user] ^= FLAG_ANEW
        self.presence[user] = Presence.JOINING

    def leave(self, user: int) -> None:
        """Take a user's avatar out; what its spring held is gone."""
        if self.presence[user] is not Presence.ABSENT:
            self.server.leave(user)
        self.presence[user] = Presence.ABSENT

    def together(self) -> bool:
        """Tell whether every user is there."""
        return self.presence.count(COUPLED) == len(self.presence)

    def step(self, now_ns: int) -> list[WavePacket | None]:
        """Advance the environment by its period; return each user's answer (None for an absent
        one).
        """
        server = self.server
        direct = bool(server.flags & FLAG_DIRECT)
        received: list[Any] = []
        for user, inbox in enumerate(self.inboxes):
            wave, quiet = inbox.take(now_ns), inbox.silent(now_ns)
            if quiet:
                wave = wave * 0.0
            if self.presence[user] is not ABSENT:
                if inbox.silence_s(now_ns) > self.release_s:
                    self.leave(user)
                else:
                    self.presence[user] = DAMPING if quiet else COUPLED
                    if inbox.newest is not None:
                        server.on_packet(user, inbox.newest)
            received.append((inbox.position(), wave) if direct else wave)
        packets: list[WavePacket | None] = []
        for user, answer in enumerate(server.step(received)):
            packet = None
            if self.presence[user] is not ABSENT:
                port = server.ports[user]
                flags, echo = server.flags | self._anew[user], self.inboxes[user].echo(now_ns)
                packet = self.packers[user].pack(
                    answer, port.x_s, now_ns, flags, echo, port.account
                )
            packets.append(packet)
        return packets
