# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end for an environment of which nothing is known but its answers (App. C).

::

    xd(n) = [sqrt(2/b) u(n) - F0/b]/(1 + G/b)         with the line F' = F0 + G xd
    F(n)  = environment(x(n), xd(n)),   v(n) = u(n) - sqrt(2/b) F(n)

The line is the environment's own where it reports its slope; else the one that the port learned
(``secant``), or the force of the step before, F' = F(n-1) (``late``). In each case (|u|^2 -
|v|^2)/2 = F . xd + d with d = F . (sqrt(2/b) u - F/b - xd), the power of decoding with another
force than F. What is done about it has a name (``compensations``); the energies are kept
(``accounts``). While the environment does not answer the port is a matched damper (v = 0).

The waves move the device by T (u + v')/sqrt(2b), with the wave v' that the compensation returned;
the avatar moves by T xd. The difference is undelivered. A port that learns repays 0.3 of it in the
next step: it decodes with that much more velocity. In a stiff contact that becomes force, and so a
returning wave, of which the compensation lets through what its energy covers.

Equations: docs/theory.md 5.1, 5.2, 5.9, 5.12.
"""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from pmwvc_core.errors import PLUGIN_ERRORS
from pmwvc_core.numeric import Array, Flag, Value, dot, squared, where
from pmwvc_core.params import ServerParams
from pmwvc_core.server.black_box.accounts import BlackBoxAccounts
from pmwvc_core.server.black_box.containment import Asked, Call, Reply, directly
from pmwvc_core.server.black_box.faults import Faults
from pmwvc_core.server.black_box.interface import BlackBox, Sloped
from pmwvc_core.server.black_box.jumps import Jumps
from pmwvc_core.server.black_box.rows import Rows
from pmwvc_core.server.black_box.secant import Secant, decoded
from pmwvc_core.server.compensations import COMPENSATIONS, Wave
from pmwvc_core.server.controller import ServerController
from pmwvc_core.server.couplings.sampled import weights
from pmwvc_core.server.cube import FixedBody
from pmwvc_core.server.user_ports import UserPort
from pmwvc_core.wave.impedance import smallest_of_runs
from pmwvc_core.wave.reflection import reflection

REPAID = 0.3  # of what is undelivered per step
DUE = "undelivered"  # of a port [m]


class BlackBoxServer(ServerController):
    """Avatars behind wave ports around a black box.

    Parameters
    ----------
    params, ports
        As for the other couplings; the contacts only give the position of the avatars.
    environment
        What is asked.
    call
        How it is asked.
    """

    BLOCKS = "_asked _compensation _kept _rows"
    MEMORY = "_secant _jumps _stored"  # the first two as a whole: there are none at first

    def __init__(
        self,
        params: ServerParams,
        ports: Sequence[UserPort],
        environment: BlackBox,
        *,
        call: Call = directly,
    ) -> None:
        super().__init__(FixedBody(), ports)  # the body is what is shown
        self._faults = self.faults = Faults("server.environment", params.environment)
        self._asked = Asked(environment)
        self._call = call
        self._compensation = COMPENSATIONS.of(params.compensation).make(params, len(ports))
        self._period = params.period_s
        self._old, self._new = weights(params.integrator, params.period_s)
        self._learns = params.learns and not isinstance(environment, Sloped)
        for port in self.ports:
            port.kept = {DUE: 0.0} if self._learns else {}
        self._secant: Secant | None = None  # made once the shape of signals is known
        self._jumps: Jumps | None = None
        self._rows = Rows()
        self._stored: Value | None = None
        self._kept = BlackBoxAccounts()

    @property
    def accounts(self) -> Mapping[str, Value]:
        """See ``accounts``, and the compensation."""
        return {**self._kept.sums, **self._compensation.accounts, **super().accounts}

    def join(self, i: int, position: Value) -> None:
        """Let user ``i`` join; the environment is notified before its next step."""
        self._rows.fit(position)
        if not any(self.present):
            try:
                self._show(self._asked.shown(self._rows.shape))
            except PLUGIN_ERRORS as error:  # whatever the plug-in raises
                self._faults.note(error)
        super().join(i, position)
        start = self._rows.of([self.ports[i].x_s])[0]
        if self._learns and self._secant is None:
            least = self._rows.of([smallest_of_runs(port.b) for port in self.ports])[..., :1]
            self._secant = Secant(least / self._period, self._rows.shape)
            self._jumps = Jumps(least, self._rows.shape, self._period)
        for learner in (self._secant, self._jumps):
            if learner is not None:
                learner.join(i, start)
        self._asked.notify("join", i, start)

    def leave(self, i: int) -> None:
        """Take user ``i`` out; the environment is notified before its next step."""
        if self.ports[i].present:
            self._asked.notify("leave", i)
        super().leave(i)

    def step(self, received: Sequence[Value]) -> list[Value]:
        """Go one step on with a wave ``(..., dof)`` [sqrt(W)] per user; return waves to send."""
        for port, wave in zip(self.ports, received, strict=True):
            if port.present:
                port.take(wave)
        start = [port.x_s + self._old * port.xd_s for port in self.ports]
        reply = self._reply(self._rows.of(start))
        waves = []
        for user, port in enumerate(self.ports):
            if port.present:
                waves.append(self._taken(user, port, reply))
                port.x_s = start[user] + self._new * port.xd_s
        returned = self._compensation.step(waves, self._held())
        for taken, v in zip(waves, returned, strict=True):
            port = self.ports[taken.user]
            self._kept.add("withheld", squared(taken.v) - squared(v), 0.5 * self._period)
            port.give(v, 0.5 * self._period)
            if self._learns:
                moved = 0.5 * port.wave.free_velocity(port.u_s + port.v_s)
                port.kept[DUE] = port.kept[DUE] + self._period * (moved - port.xd_s)
        self.dissipated = self._kept.spent - self.potential
        return [port.v_s for port in self.ports]

    def _reply(self, start: Array) -> Reply | None:
        """Return the environment's answer; None where there is none to be used."""
        velocity = self._guess(start)
        exchange = partial(self._asked.exchange, period=self._period, weight=self._new)
        try:
            reply: Reply = self._call(partial(exchange, start, velocity, decode=self._decoded))
        except PLUGIN_ERRORS as error:  # whatever the plug-in raises
            self._faults.note(error)
            return None
        return self._checked(reply, start + self._new * reply.velocity)

    def _checked(self, reply: Reply, position: Array) -> Reply:
        """Note the forces that cannot be used; learn from the others, and what it shows."""
        steady = reply.good
        if self._jumps is not None:
            went = self._period * np.linalg.norm(self._rows.of([self.body.xd]), axis=-1)
            steady = self._jumps.explained(position, reply.force, steady, went[0, ..., None])
        self._faults.note_users(reply.good, "no usable force (not finite, or beyond 1e6 N)")
        self._faults.note_users(steady, "a force that jumped while hardly anything moved")
        good = reply.good & steady
        if self._secant is not None:
            self._secant.learn(position, reply.force, good)
        self._stored = reply.stored
        self._show(reply.shown)
        return reply._replace(good=good)

    def _guess(self, start: Array) -> Array:
        """Return the velocities decoded with the learned line, or with the last force."""
        if self._secant is None:
            late = [
                port.wave.velocity(port.u_s, port.f_s) if port.present else 0.0
                for port in self.ports
            ]
            return self._rows.of(late)
        free = [port.wave.free_velocity(port.u_s) + self._repaid(port) for port in self.ports]
        drive = [port.b * velocity for port, velocity in zip(self.ports, free, strict=True)]
        b = self._rows.matrices([port.b for port in self.ports])
        line = self._secant.line(start, self._new)
        velocity, expected = decoded(line, self._rows.of(drive), b)
        self._secant.expect(expected)
        return velocity

    def _repaid(self, port: UserPort) -> Value:
        """Return the velocity that repays [m/s]; a braked avatar waits."""
        return 0.0 if port.front else port.kept[DUE] * (REPAID / self._period)

    def _taken(self, user: int, port: UserPort, reply: Reply | None) -> Wave:
        """Give a port its velocity and force; return its waves, zero where it is contained."""
        damped = 0.5 * port.wave.free_velocity(port.u_s)
        if reply is None:
            good: Flag = False
            velocity, force = damped, port.b * damped
        else:
            good = self._rows.flag(reply.good[user])
            velocity = where(good, self._rows.value(reply.velocity[user]), damped)
            force = where(good, self._rows.value(reply.force[user]), port.b * damped)
        port.xd_s, port.f_s = velocity, force
        u = where(good, port.u_s, 0.0 * port.u_s)
        v = where(good, port.wave.v(port.u_s, force), 0.0 * port.u_s)
        late = where(good, dot(force, port.wave.velocity(port.u_s, force) - velocity), 0.0)
        kept, h = self._kept, self._period
        kept.add("environment", where(good, dot(force, velocity), 0.0), h)
        kept.add("late_decoding", late, h)
        kept.add("contained", squared(port.u_s) - squared(u), 0.5 * h)
        return Wave(user, u, v, late)

    def _held(self) -> Value | None:
        """Return what can still come out: the environment's energy and that of late decoding [J].

        Decoding with F(n-1) takes |F|^2 h/(2b) while a force builds up and gives it out again;
        with a slope it gives out up to G/b times what the environment does.
        """
        held = self._stored
        if held is None:
            return None
        if self._secant is not None:
            most = self._secant.ratio.max(axis=0) * self._new / self._period
            held = held * (1.0 + self._rows.value(most))
        for port in self.ports:
            b = port.front.b if port.front else port.b
            held = held + 0.5 * self._period * dot(port.f_s, port.f_s / b)
        return held

    def _decoded(self, force: Array, slope: Array) -> Array:
        """Return xd = sqrt(2/b) u - (F0 + G xd)/b of every user."""
        value = self._rows.value
        lines = zip(self.ports, map(value, force), map(value, slope), strict=True)
        return self._rows.of([reflection(port.b).solve(port.u_s, f, g)[1] for port, f, g in lines])

    def _show(self, shown: tuple[Array, Array] | None) -> None:
        """Note the position of the object that the environment reports."""
        if shown is not None:
            self.body.x, self.body.xd = map(self._rows.value, shown)

    def learned(self, i: int) -> Value | None:
        """Return (K T + 2B)/b of what user ``i`` touches, as learned; None where nothing is."""
        return None if self._secant is None else self._rows.value(self._secant.learned[i])

    @property
    def contact(self) -> list[Flag]:
        """Users whose avatar is under a force."""
        return [squared(port.f_s) > 0.0 if port.present else False for port in self.ports]

    @property
    def potential(self) -> Value:
        """Energy in the environment, zero where it is not reported [J]."""
        return 0.0 if self._stored is None else self._stored
