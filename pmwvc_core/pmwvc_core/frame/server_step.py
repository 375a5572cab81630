# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end of the frame protocol: receivers, membership, the environment's step, target
and senders for all users.

A user joins with its first packet (or with a new epoch: it was restarted), is rendered a matched
damper while it is silent (braked on the strict channel, also while it does not hear the server),
and leaves with its last packet or after ``release_s`` of silence.
Time is an argument: integer nanoseconds of any monotonic clock.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from pmwvc_core.frame.end import ProtocolEnd, waiting
from pmwvc_core.frame.rows import Presence, ServerRow
from pmwvc_core.numeric import Value, anywhere
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.plant.task import ShownTarget
from pmwvc_core.server.controller import ServerController
from pmwvc_core.transport.packet import (
    FLAG_ANEW,
    FLAG_CHALLENGE,
    FLAG_DIRECT,
    FLAG_LEAVING,
    Packer,
    WavePacket,
)
from pmwvc_core.transport.receiver import Receiver
from pmwvc_core.transport.verdict import Verdict
from pmwvc_core.wave.impedance import Impedance
from pmwvc_core.wave.limits import largest_wave

# At hand: a member is looked up in Python.
ABSENT, COUPLED, DAMPING = Presence.ABSENT, Presence.COUPLED, Presence.DAMPING
ACCEPTED, NEW_EPOCH = Verdict.ACCEPTED, Verdict.NEW_EPOCH


class ServerStep(ProtocolEnd):
    """All users' server ports around one environment.

    Parameters
    ----------
    target
        Where the object is to be brought.
    params
        Of the server.
    inboxes, packers
        One receiver and one sender per user.
    idle_until_joined
        Whether steps begin with the first user rather than with the first tick.

    Attributes
    ----------
    params, period_s
        Parameters of the server, and time of the present step [s].
    steps
        Steps made so far.
    presence
        State of every user.
    """

    BLOCKS = "server target inboxes packers"
    MEMORY = "presence steps paused period_s _idle _anew"

    def __init__(
        self,
        server: ServerController,
        target: ShownTarget,
        *,
        params: ServerParams,
        inboxes: Sequence[Receiver],
        packers: Sequence[Packer],
        release_s: float,
        idle_until_joined: bool = False,
    ) -> None:
        super().__init__()
        self.server = server
        self.target = target
        self.params = params
        self.period_s = params.period_s
        self.inboxes = list(inboxes)
        self.packers = list(packers)
        self.release_s = release_s
        self.presence = [ABSENT for _ in self.inboxes]
        self.steps = 0
        self.paused = False
        self._idle = idle_until_joined
        self._anew = [0 for _ in self.inboxes]  # FLAG_ANEW of each user's packets

    def pause(self, paused: bool) -> None:
        """Stand still, or go on. Users leave, and join anew afterwards: a device that moves on
        meanwhile is not where its avatar was.
        """
        self.paused = paused
        if paused:
            for user in range(len(self.presence)):
                self._leave(user)

    @property
    def flags(self) -> int:
        """Flags of all packets."""
        return self.server.flags

    @property
    def faults(self) -> Any:
        """What went wrong in environment or coupling."""
        return self.server.faults

    @property
    def x_o(self) -> Value:
        """Position of the object [m]."""
        return self.server.x_o

    @property
    def target_m(self) -> Value:
        """Where the object is to be brought [m]."""
        return self.target.position_m

    def avatar(self, user: int) -> tuple[Value, Value]:
        """Return where a user's avatar is [m], and its force on the object [N]."""
        return self.server.x_s[user], self.server.f_s[user]

    def offset(self, user: int) -> Value:
        """Return how far an avatar is from its device without a force [m]."""
        return self.server.ports[user].offset

    def learned(self, user: int) -> Any:
        """Return (K T + 2B)/b of what a user touches, where its port learns it."""
        return self.server.learned(user)

    def configure(self, params: ServerParams, *, first_s: float) -> None:
        """Take other parameters over before a step.

        Parameters
        ----------
        params
            Of the server.
        first_s
            Time of the step that begins [s]; another one than the period where that changes and
            the steps after it lie on another grid.
        """
        self.params = params
        regular = math.isclose(first_s, params.period_s)
        self._last(params.period_s if regular else first_s)

    def _last(self, period_s: float) -> None:
        """Let the steps from here on last so long [s]."""
        self.period_s = period_s
        self.server.configure(replace(self.params, period_s=period_s))
        self.target.period_s = period_s
        for packer in self.packers:
            packer.period = period_s

    def configure_user(self, user: int, contact: ContactParams, impedance: Impedance) -> None:
        """Take other parameters of a user's contact, port and sender over."""
        self.server.configure_user(user, contact, impedance)
        self.packers[user].deadband.configure(contact.deadband)
        waves = not self.server.flags & FLAG_DIRECT
        self.inboxes[user].max_wave = largest_wave(impedance, waves=waves)

    def tick(
        self, now_ns: int, packets: Sequence[Iterable[WavePacket]], missed_s: float = 0.0
    ) -> tuple[list[WavePacket | None], ServerRow | None]:
        """Take in what has arrived, advance the environment by its period, answer.

        Parameters
        ----------
        packets
            Of each user, arrived since the last step, in the order of arrival.
        missed_s
            For how long steps that were due before this one did not run [s].

        Returns
        -------
        tuple
            Each user's answer (None for an absent one, but where its sender has to prove itself,
            and where the deadband holds it back), and
            the server after the step (None while it waits for the first user, or is paused).
        """
        if self.period_s != self.params.period_s:
            self._last(self.params.period_s)
        self._take_changes()
        if self.paused:
            for inbox, arrived in zip(self.inboxes, packets, strict=True):
                for packet in arrived:
                    inbox.push(packet, now_ns)
            return [None for _ in self.presence], None
        for user, arrived in enumerate(packets):
            there = self.presence[user] is not ABSENT
            for packet in arrived:
                self.deliver(user, packet, now_ns)
            if missed_s > 0.0 and there:
                self.inboxes[user].playout.pass_by(missed_s)
        if self._idle and self.presence.count(ABSENT) == len(self.presence):
            return [None for _ in self.presence], None
        self._idle = False
        self.steps += 1
        answers: list[WavePacket | None] = []
        server = self.server
        for user, answer in enumerate(server.step(self._received(now_ns))):
            answered, absent = None, self.presence[user] is ABSENT
            inbox, packer = self.inboxes[user], self.packers[user]
            flags = server.flags | self._anew[user] | waiting(inbox)
            if not absent and inbox.plays_on:
                self._pass_on(user)
            if not absent and not packer.holds_back(answer, flags):
                port = server.ports[user]
                at = port.x_s - port.offset  # in the frame of the device
                echo, short = inbox.echo(now_ns), inbox.playout.short
                answered = packer.pack(answer, at, now_ns, flags, echo, port.account, short)
            elif absent and inbox.challenges(now_ns):
                flags, rest = flags | FLAG_CHALLENGE, 0.0 * answer
                echo, account = inbox.echo(now_ns), server.ports[user].account
                answered = packer.pack(rest, rest, now_ns, flags, echo, account)
            answers.append(answered)
        self.target.step(together=self.presence.count(COUPLED) == len(self.presence))
        presence = tuple(self.presence)
        return answers, ServerRow.of(server, self.target.position_m, presence)

    def _pass_on(self, user: int) -> None:
        """Send energy back that a user lacks and its wave does not need here: the port takes it
        and gives it.
        """
        passed = self.inboxes[user].spared(self.period_s)
        if anywhere(passed > 0.0):
            self.packers[user].pay(passed)
            port = self.server.ports[user]
            port.energy_u_s = port.energy_u_s + passed
            port.energy_v_s = port.energy_v_s + passed

    def deliver(self, user: int, packet: WavePacket, now_ns: int) -> None:
        """Take one packet of a user in; a first one, or one of a new life, joins the user."""
        if self._refuses(packet, self.server.flags):
            return
        verdict = self.inboxes[user].push(packet, now_ns)
        if verdict is not ACCEPTED and verdict is not NEW_EPOCH:
            return
        if packet.flags & FLAG_LEAVING:
            self._leave(user)
        elif verdict is NEW_EPOCH or self.presence[user] is ABSENT:
            self._join(user, packet.position)

    def _join(self, user: int, position: Value) -> None:
        """Put a user's avatar where its device is, without a force."""
        if self.presence[user] is not ABSENT:
            self.server.leave(user)
        self.server.join(user, position)
        self.inboxes[user].playout.begin()
        self._anew[user] ^= FLAG_ANEW
        self.presence[user] = Presence.JOINING

    def _leave(self, user: int) -> None:
        """Take a user's avatar out; the energy in its spring is lost."""
        if self.presence[user] is not ABSENT:
            self.server.leave(user)
        self.presence[user] = ABSENT

    def _received(self, now_ns: int) -> list[Any]:
        """Return each user's wave (with its position for direct coupling); zero when silent."""
        server = self.server
        direct = bool(server.flags & FLAG_DIRECT)
        received: list[Any] = []
        for user, inbox in enumerate(self.inboxes):
            wave, quiet = inbox.playout.step(self.period_s), inbox.silent(now_ns)
            if quiet and not inbox.plays_on:
                wave = wave * 0.0
            if self.presence[user] is not ABSENT:
                if inbox.silence_s(now_ns) > self.release_s:
                    self._leave(user)
                else:
                    interrupted, unreceived = inbox.waits(now_ns)
                    self.presence[user] = DAMPING if quiet or unreceived else COUPLED
                    server.interrupt(user, interrupted)
                    if inbox.newest is not None:
                        server.on_packet(user, inbox.newest)
            received.append((inbox.position(), wave) if direct else wave)
        return received
