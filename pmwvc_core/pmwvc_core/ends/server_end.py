# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end of a session: what :mod:`pmwvc_core.law.server_step` has in order, with the
packets, changes and observers.

A user joins with its first packet (or with a new epoch: it was restarted), is rendered a matched
damper while it is silent (braked on the strict channel, also while it does not hear the server),
and leaves with its last packet or after ``release_s`` of silence.
Time is an argument: integer nanoseconds of any monotonic clock.
"""

import dataclasses
import math
from collections.abc import Iterable, Sequence
from typing import Any

from pmwvc_core.ends.changes import Changes
from pmwvc_core.ends.forms import message, value
from pmwvc_core.ends.guests import all_left, challenge, counted
from pmwvc_core.ends.inbox import Inbox
from pmwvc_core.ends.server_row import PRESENCES, row_of
from pmwvc_core.frame.rows import Presence, ServerRow
from pmwvc_core.law.channel.arrivals import arrivals_of
from pmwvc_core.law.server.energies import port_shown
from pmwvc_core.law.server.server_port import changed_port
from pmwvc_core.law.server_step import ABSENT, Answer, server_step
from pmwvc_core.made.accounts import accounts_of_server
from pmwvc_core.made.server import resting_server, server_params
from pmwvc_core.made.server_changes import alike, changed_server
from pmwvc_core.made.waves import made_impedance
from pmwvc_core.numeric import Value
from pmwvc_core.params import ContactParams, ServerParams, TaskParams
from pmwvc_core.params.user import ServerTimes
from pmwvc_core.plant.task import Task
from pmwvc_core.scenario.scenario import User
from pmwvc_core.server.black_box.containment import Call, directly
from pmwvc_core.server.black_box.faults import Faults, Unsettled
from pmwvc_core.server.black_box.outside import Outside
from pmwvc_core.server.couplings.contained import Contained
from pmwvc_core.transport.packet import FLAG_CHALLENGE, WavePacket
from pmwvc_core.unrolled import unrolled
from pmwvc_core.wave.impedance import Impedance


class ServerEnd:
    """All users' ports around one environment.

    Parameters
    ----------
    users
        Of each the side, contact, baseline, and the impedance and frame of the master.
    controller, channel, dof, server, task
        Of the session.
    own
        Parameters of environments from other packages, by their names.
    times
        Silence, release and start.
    epochs
        Of the packets to each user.
    call
        How an environment of another package is asked; directly by default.
    idle_until_joined
        Whether steps begin with the first user rather than with the first tick.

    Attributes
    ----------
    params, period_s
        Parameters of the server, and time of the present step [s].
    inboxes
        One receiver per user.
    steps
        Steps made so far.
    paused
        Whether it stands still.
    faults
        Steps whose equation was not solved.
    """

    def __init__(
        self,
        users: Sequence[User],
        *,
        controller: str,
        channel: str,
        dof: int,
        server: ServerParams,
        task: TaskParams,
        own: Any = None,
        times: ServerTimes,
        epochs: Sequence[int],
        call: Call = directly,
        idle_until_joined: bool = False,
    ) -> None:
        self._users, self.params, self._epochs = list(users), server, list(epochs)
        self._session: dict[str, Any] = {
            "controller": controller,
            "channel": channel,
            "times": times,
            "axes": dof,
        }
        self.p = self._made(server.period_s)
        s = resting_server(
            users, self.p, controller=controller, server=server, axes=dof, own=own, call=call
        )
        rest = (0.0,) * dof
        guests = (guest._replace(arrivals=arrivals_of(guest.arrivals, rest)) for guest in s.guests)
        self.s = s._replace(guests=tuple(guests))
        self.faults = self._found_faults()
        self.inboxes = [
            Inbox(
                controller,
                channel,
                dof,
                user.server_impedance,
                period_s=user.master.frame_s,
                timeout_s=times.timeout_s,
                from_server=False,
            )
            for user in users
        ]
        self._step = unrolled(server_step, dof)
        self._task, self._dof = Task(task), dof
        self._accounts = [each.name for each in accounts_of_server(controller, channel, server)]
        self._changes = Changes()
        self.hand_over = self._changes.hand_over
        self.steps = 0
        self.paused = False
        self._idle = idle_until_joined

    def _made(self, period_s: float) -> Any:
        server = dataclasses.replace(self.params, period_s=period_s)
        return server_params(self._users, server=server, **self._session)

    @property
    def period_s(self) -> float:
        """Time of the present step [s]."""
        return self.p.period_s  # type: ignore[no-any-return]

    @property
    def presence(self) -> list[Presence]:
        """State of every user."""
        return [PRESENCES[guest.presence] for guest in self.s.guests]

    @property
    def changes(self) -> int:
        """Steps that took changes over."""
        return self._changes.made

    @property
    def other_controller(self) -> int:
        """Packets of another kind of controller, which are ignored."""
        return sum(inbox.other_controller for inbox in self.inboxes)

    @property
    def flags(self) -> int:
        """Flags of all packets."""
        return self.inboxes[0].flags

    @property
    def x_o(self) -> Value:
        """Position of the object [m]."""
        return value(self.s.environment.body.x)

    @property
    def target_m(self) -> Value:
        """Where the object is to be brought [m]."""
        time_s = self.s.task_s
        return self._task.offset(max(time_s, 0.0) if time_s < math.inf else 0.0, dof=self._dof)

    def avatar(self, user: int) -> tuple[Value, Value]:
        """Return where a user's avatar is [m], and its force on the object [N]."""
        port = self.s.environment.ports[user]
        return value(port.x_s), value(port.avatar.f)

    def offset(self, user: int) -> Value:
        """Return how far an avatar is from its device without a force [m]."""
        return value(self.s.environment.ports[user].offset)

    def learned(self, user: int) -> float | None:
        """Return (K T + 2B)/b of what a user touches, where its port learns it."""
        p, s = self.p.environment, self.s.environment
        return float(port_shown(p, s, user).learned) if getattr(p, "learns", False) else None

    def pause(self, paused: bool) -> None:
        """Stand still, or go on. Users leave, and join anew afterwards: a device that moves on
        meanwhile is not where its avatar was.
        """
        self.paused = paused
        if paused:
            self.s = all_left(self.s)

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
        before, self.params = self.params, params
        if params.coupling != before.coupling:
            self.faults = self._found_faults()
        regular = math.isclose(first_s, params.period_s)
        self._last(params.period_s if regular else first_s)

    def _found_faults(self) -> Faults:
        """Return what counts the steps that went wrong."""
        asked = getattr(self.s.environment.body, "environment", None)
        if isinstance(asked, Outside):
            return asked.faults
        coupling = getattr(self.p.environment, "coupling", None)
        if isinstance(coupling, Contained):
            return coupling.faults
        return Faults("server.coupling", self.params.coupling)

    def _counting(self, p: Any) -> Any:
        """Let a coupling of another package go on counting its faults."""
        coupling = getattr(p.environment, "coupling", None)
        was = getattr(self.p.environment, "coupling", None)
        if not (isinstance(coupling, Contained) and isinstance(was, Contained)):
            return p
        coupling = coupling._replace(faults=was.faults)
        return p._replace(environment=p.environment._replace(coupling=coupling))

    def _last(self, period_s: float) -> None:
        """Let the steps from here on last so long [s]."""
        p = self._counting(self._made(period_s))
        self.s = self.s._replace(environment=changed_server(self.s.environment, self.p, p))
        self.p = p

    def configure_user(self, user: int, contact: ContactParams, impedance: Impedance) -> None:
        """Take other parameters of a user's contact, port and sender over."""
        self._users[user] = dataclasses.replace(self._users[user], contact=contact)
        e = self.s.environment
        stiffness, damping = contact.contact_stiffness, contact.contact_damping
        b = made_impedance(impedance)
        port, lost_j = changed_port(e.ports[user], stiffness, damping, b)
        ports = alike((*e.ports[:user], port, *e.ports[user + 1 :]), self._users)
        e = e._replace(ports=ports, dissipated_j=e.dissipated_j + lost_j)
        self.s = self.s._replace(environment=e)
        arrivals = [guest.arrivals for guest in self.p.guests]
        self.p = self._counting(self._made(self.period_s))
        # What a receiver was made for stays; the longest wave is the receiver's to know.
        guests = zip(self.p.guests, arrivals, strict=True)
        kept = tuple(guest._replace(arrivals=of) for guest, of in guests)
        self.p = self.p._replace(guests=kept)
        self.inboxes[user].match(impedance)

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
            and where the deadband holds it back), and the server after the step (None while it
            waits for the first user, or is paused).
        """
        if self.period_s != self.params.period_s:
            self._last(self.params.period_s)
        self._changes.take()
        pairs = zip(self.inboxes, packets, strict=True)
        taken = tuple(inbox.take(arrived, now_ns) for inbox, arrived in pairs)
        nothing: list[WavePacket | None] = [None for _ in self.inboxes]
        if self.paused:
            self.s = counted(self.s, self.p, now_ns, taken)
            self._expect()
            return nothing, None
        if self._idle and not any(taken):
            return nothing, None
        self._idle = False
        self.steps += 1
        unsettled = self.s.environment.unsettled
        self.s, answers = self._step(self.s, now_ns, taken, missed_s, self.p)
        if self.s.environment.unsettled > unsettled:
            self.faults.note(Unsettled())
        self._expect()
        sent = [self._answered(user, answer, now_ns) for user, answer in enumerate(answers)]
        return sent, row_of(self.s, self.p, self._accounts, self.target_m)

    def _answered(self, user: int, answer: Answer, now_ns: int) -> WavePacket | None:
        """Return what goes back to a user; one that is to prove itself is asked to."""
        inbox, packet, flags = self.inboxes[user], answer.packet, self.flags
        if not answer.sends:
            absent = self.s.guests[user].presence == ABSENT
            if not (absent and inbox.challenges(now_ns)):
                return None
            self.s, packet = challenge(self.s, self.p, user, now_ns)
            flags |= FLAG_CHALLENGE
        return message(packet, self._epochs[user], flags, inbox.echo(now_ns))

    def _expect(self) -> None:
        """Tell the receivers from when on users are silent."""
        for inbox, guest in zip(self.inboxes, self.s.guests, strict=True):
            inbox.expect(guest.arrivals.silence.limit_ns)
