# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end of a session: what :mod:`pmwvc_core.law.server_step` has in order, with
packets, changes and observers. A user joins with its first packet, or a new epoch, is rendered a
matched damper while it is silent (braked on the strict channel, also while it does not hear the
server), and leaves with its last packet or after ``release_s`` of silence. Time is an argument
[ns].
"""

import dataclasses
import math
from collections.abc import Iterable, Sequence
from operator import call as at_once
from typing import Any

from pmwvc_core.controllers.library import accounts_of_server
from pmwvc_core.ends.inbox import Inbox, PortEnd, message, value
from pmwvc_core.frame import Presence, ServerRow
from pmwvc_core.law.channel.arrivals import news
from pmwvc_core.law.channel.packet import Packet, Sent, pack
from pmwvc_core.law.server.server_port import changed_port, port_shown, scene_energies, sum_j
from pmwvc_core.law.server_step import ABSENT, server_step
from pmwvc_core.law.vectors import zero
from pmwvc_core.law.wave.wave import firmer
from pmwvc_core.made.server import changed_server, port_impedance, resting_server, server_params
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.plant.forces import offset, task_of
from pmwvc_core.plugins import BadAnswer, Faults
from pmwvc_core.server.black_box import Call, Outside, shown_by
from pmwvc_core.server.turned import Turned
from pmwvc_core.transport.packet import FLAG_CHALLENGE, WavePacket
from pmwvc_core.unrolled import unrolled
from pmwvc_core.wave.impedance import Impedance

SERVER_EPOCH = 1000  # of scenarios; random in live sessions, where a process can start again
JUMPED = "a force that jumped while hardly anything moved"
LEAST_M = 1e-3  # avatars less far from their device are not reported


def kept_words(distance_m: float, *, waves: bool, black_box: bool) -> str:
    """Return the distance of an avatar from its device since joining, and why it stays, for a
    controller and an environment; nothing below ``LEAST_M``.
    """
    if not distance_m > LEAST_M:
        return ""
    why = "it joined with the device inside the object, and slides to it once there is room"
    if black_box:
        why = "an environment known by its forces only has no face to stop at, so it cannot slide"
    if not waves:
        why = "this controller keeps the distance"
    return f"avatar {1e3 * distance_m:.1f} mm from the device since joining: {why}"


class ServerEnd(PortEnd):
    """All users' ports around one environment.

    ``session`` has controller, channel, axes, users, server, task, ``times`` of silence, release
    and start, and the parameters ``own`` of environments from other packages (a scenario, or what
    a node was given); ``epoch`` is that of all packets, by default those of a scenario; ``call``
    says how an environment of another package is asked. Steps may be ``idle_until_joined``.
    ``params`` are those of the server, ``steps`` were made so far, ``faults`` counts those whose
    equation was not solved.
    """

    def __init__(
        self, session: Any, *, epoch: int | None = None, call: Call = at_once,
        idle_until_joined: bool = False,
    ) -> None:  # fmt: skip
        self._session, self._users = session, list(session.users)
        self.params: ServerParams = session.server
        count, dof = len(self._users), session.dof
        first, step = (SERVER_EPOCH, 1) if epoch is None else (epoch, 0)
        self._epochs = [first + step * number for number in range(count)]
        self.faults = Faults("server.coupling", self.params.coupling)
        self.p = self._made(self.params.period_s)
        self.s = resting_server(self._users, session, self.p, call)
        asked = getattr(self.s.environment.body, "environment", None)
        self._turned = Turned((count, dof), self.params)
        if isinstance(asked, Outside):
            self.faults, self._turned = asked.faults, asked.turned
        inboxes = []
        for user in self._users:
            times_s = {"period_s": user.master.frame_s, "timeout_s": session.times.timeout_s}
            inboxes.append(Inbox(session, user.server_impedance, from_server=False, **times_s))
        super().__init__(inboxes)
        self._step, self._task = unrolled(server_step, dof), task_of(session.task, dof)
        kept = accounts_of_server(session.controller, session.channel, self.params)
        self._accounts = [each.name for each in kept]
        self.steps, self._idle = 0, idle_until_joined

    def _made(self, period_s: float) -> Any:
        """Return the parameters for steps of that length [s]."""
        server = dataclasses.replace(self.params, period_s=period_s)
        return server_params(self._users, self._session, server, self.faults)

    def configure(self, params: ServerParams, *, first_s: float) -> None:
        """Take other parameters over before a step, which lasts ``first_s`` [s]."""
        before, self.params = self.params, params
        if params.coupling != before.coupling:
            self.faults = Faults("server.coupling", params.coupling)
        self._last(params.period_s if math.isclose(first_s, params.period_s) else first_s)

    def _last(self, period_s: float) -> None:
        """Let the steps from here on last so long [s]."""
        p = self._made(period_s)
        self.s = self.s._replace(environment=changed_server(self.s.environment, self.p, p))
        self.p = p

    def configure_user(self, user: int, contact: ContactParams, impedance: Impedance) -> None:
        """Take other parameters of a user's contact, port and sender over."""
        self._users[user] = dataclasses.replace(self._users[user], contact=contact)
        e = self.s.environment
        b = port_impedance(impedance, self._users, self._session)
        b = firmer(b, (self.s.guests[user].following.ratio,) * self._session.dof)
        law = contact.contact_stiffness, contact.contact_damping, b
        port, lost_j = changed_port(e.ports[user], *law)
        ports = (*e.ports[:user], port, *e.ports[user + 1 :])
        e = e._replace(ports=ports, dissipated_j=e.dissipated_j + lost_j)
        self.s = self.s._replace(environment=e)
        p = self._made(self.p.period_s)
        pairs = zip(p.guests, self.p.guests, strict=True)
        # What a receiver was made for stays; the longest wave is the receiver's to know.
        self.p = p._replace(
            guests=tuple(new._replace(arrivals=old.arrivals) for new, old in pairs)
        )
        self.inboxes[user].match(impedance)

    def tick(
        self, now_ns: int, packets: Sequence[Iterable[WavePacket]], missed_s: float = 0.0
    ) -> tuple[list[WavePacket | None], ServerRow | None]:
        """Take in what has arrived since the last step, by user in the order of arrival; advance
        the environment by its period, after steps that did not run for ``missed_s`` [s]; answer.

        Return each user's answer (None for an absent one, but where its sender has to prove
        itself, and where the deadband holds it back), and the server after the step (None while it
        waits for the first user).
        """
        if self.p.period_s != self.params.period_s:
            self._last(self.params.period_s)
        self._take_changes()
        pairs = zip(self.inboxes, packets, strict=True)
        taken = tuple(inbox.take(arrived, now_ns) for inbox, arrived in pairs)
        if self._idle and not any(taken):
            return [None for _ in self.inboxes], None
        self._idle = False
        self.steps += 1
        for user, inbox in enumerate(self.inboxes):
            if inbox.newest is not None and inbox.orientation:
                self._turned.devices[user] = inbox.newest.position, inbox.orientation
        unsettled = self.s.environment.unsettled
        self.s, answers = self._step(self.s, now_ns, taken, missed_s, self.p)
        if self.s.environment.unsettled > unsettled:
            # Not solved to rounding: the best solution was used.
            self.faults.note(BadAnswer("did not settle"))
        of_users = getattr(self.s.environment.body, "users", ())
        self.faults.note_users((each.there and each.jumped for each in of_users), JUMPED)
        for inbox, guest in zip(self.inboxes, self.s.guests, strict=True):
            inbox.silence_ns = guest.arrivals.silence.limit_ns
        sent = [self._answered(user, answer, now_ns) for user, answer in enumerate(answers)]
        return sent, self.row()

    def _answered(self, user: int, answer: tuple[Packet, bool], now_ns: int) -> WavePacket | None:
        """Return what goes back to a user; one that is to prove itself is asked to."""
        inbox, (packet, sends) = self.inboxes[user], answer
        flags = inbox.flags
        if not sends:
            guest, port, p = self.s.guests[user], self.s.environment.ports[user], self.p
            if not (guest.presence == ABSENT and inbox.challenges(now_ns)):
                return None
            # A packet of nothing, which an answer has to echo.
            rest, q = zero(port.x_s), p.guests[user]
            sent = Sent(rest, rest, sum_j(port, q.arrivals.plays_on), port.extra, 0)
            _, waits = news(guest.arrivals, q.arrivals)
            about = now_ns, (False, waits), guest.anew, False, 0, 1
            packed, packet, _ = pack(guest.packing, sent, p.period_s, *about, q.packing)
            guests = list(self.s.guests)
            guests[user] = guest._replace(packing=packed)
            self.s, flags = self.s._replace(guests=tuple(guests)), flags | FLAG_CHALLENGE
        turned = tuple(self._turned.handles[user])
        return message(packet, self._epochs[user], flags, inbox.echo(now_ns), turned)

    @property
    def presence(self) -> list[Presence]:
        """State of every user."""
        return [Presence(guest.presence) for guest in self.s.guests]

    def row(self) -> ServerRow:
        """Return all of it, with the energies that the environment counts by name."""
        p, e, time_s = self.p.environment, self.s.environment, self.s.task_s
        kinetic, potential, *energies = scene_energies(p, e)
        of_users = []
        for user, port in enumerate(e.ports):
            a, shown = port.avatar, port_shown(p, e, user)
            motion = map(value, (port.x_s, a.xd, a.f, a.u, shown.v_s))
            of_users.append((*motion, port.u_j, port.v_j, shown.touches))
        target = offset(time_s if time_s < math.inf else 0.0, self._task)
        of_object = value(e.body.x), value(e.body.xd), value(target)
        sums, columns = (kinetic, potential, e.dissipated_j), zip(*of_users, strict=True)
        accounts = dict(zip(self._accounts, energies, strict=False))
        about = tuple(self.presence), accounts, *shown_by(e.body), self.faults.steps
        return ServerRow._make((*of_object, *sums, *columns, *about))
