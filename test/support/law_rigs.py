# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws with their state, stepped on floats (on arrays where a test has several axes): the limits
between a controller and a device, and the users around an environment.
"""

import operator
from collections import deque

import numpy as np

import pmwvc_core.law.port.strict_master  # noqa: F401  # joins the families
from pmwvc_core.controllers.library import accounts_of_server
from pmwvc_core.ends.inbox import value, vector
from pmwvc_core.ends.server_end import JUMPED
from pmwvc_core.law.safety.brakes import AvatarBrake, loose_brake, resting_brake
from pmwvc_core.law.safety.limits import NONE, Limits, Part, limits, limits_restart
from pmwvc_core.law.server.server_port import (
    Came,
    environment_step,
    joined,
    left,
    port_shown,
    scene_energies,
)
from pmwvc_core.made.server import resting_server, server_params
from pmwvc_core.made.user import groups_of, limits_params
from pmwvc_core.master.safety import state_of, text_of
from pmwvc_core.params import MasterParams, SafetyParams
from pmwvc_core.plugins import Faults
from pmwvc_core.scenario.scenario import User
from pmwvc_core.server.black_box import Outside
from pmwvc_core.server.turned import Turned
from support.session_given import session_given


class ForceLimits:
    """The limits of a loop without a brake."""

    def __init__(self, *, tick_s=0.001, packet_s=0.008, axes=1, groups=None, brake=0.0, **params):
        self.axes, self.params = axes, SafetyParams(**params)
        self._times = tick_s, packet_s, brake, groups or (((1.0,) * axes, 1.0),)
        self.p = limits_params(self.params, *self._times)
        nothing = (0.0,) * axes
        parts = (Part(loose_brake(nothing)),) * len(self.p.groups)
        self.s, self.x = Limits(nothing, nothing, parts, self.p.timeout_s), nothing

    def __call__(
        self, f, xd=0.0, *, x=0.0, silence_s=0.0, coupled=True, interrupted=False, ticks=1
    ):
        f, x, xd = (vector(signal, self.axes) for signal in (f, x, xd))
        about = xd, silence_s, coupled, True, interrupted, False, False
        for _ in range(ticks):
            self.s, applied = limits(self.s, f, x, self.x, *about, self.p)
            self.x = x
        return value(applied)

    def configure(self, **params):
        self.params = SafetyParams(**params)
        self.p = limits_params(self.params, *self._times)

    def rearm(self):
        self.s = self.s._replace(fault=NONE)

    def restart(self):
        self.s = limits_restart(self.s)

    state = property(lambda self: state_of(self.s.cause))
    reason = property(lambda self: text_of(self.s.cause, self.params))
    events = property(lambda self: self.s.events)
    ready = property(lambda self: self.s.ready)


def loose_avatar(axes, brakes=None):
    """The brakes of an avatar, which hold nothing."""
    rest = (0.0,) * axes
    return AvatarBrake((resting_brake(rest),) * len(brakes or groups_of(axes)), rest, 0.0)


class Users:
    """The users of a server, without packets: waves in, waves out."""

    def __init__(
        self,
        server,
        contacts,
        *,
        controller="pmwvc",
        channel="plain",
        b=25.0,
        masters=None,
        axes=1,
        sides=None,
        environment=None,
        call=operator.call,
        baseline=None,
        of_environments=None,
    ):
        self.axes, self.server = axes, server
        sides = sides or [-1 if i % 2 == 0 else 1 for i in range(len(contacts))]
        own = {} if baseline is None else {"baseline": baseline}
        masters = masters or [MasterParams(impedance=b)] * len(contacts)
        users = [
            User(f"user{side}", side=side, contact=contact, master=master, **own)
            for side, contact, master in zip(sides, contacts, masters, strict=True)
        ]
        of = {"controller": controller, "channel": channel, "dof": axes, "server": server}
        session = session_given(**of, own=of_environments)
        p = server_params(users, session, server)
        made = resting_server(users, session, p, call)
        self.p, self.s = p.environment, made.environment
        self._sums = [None] * len(users)
        self.received_j = [0.0] * len(users)  # by the sums of packets, without waves
        self.faults = Faults("server.environment", server.environment)
        if environment is not None:
            there = (False,) * len(users)
            places = np.zeros((len(users), axes))
            turned = Turned(places.shape, server)
            outside = Outside(environment, deque(), call, self.faults, there, places, turned)
            self.s = self.s._replace(body=self.s.body._replace(environment=outside))
        elif isinstance(getattr(self.s.body, "environment", None), Outside):
            self.faults = self.s.body.environment.faults
        names = accounts_of_server(controller, channel, server)
        self._names = ("kinetic", "potential", *(entry.name for entry in names))

    def join(self, user, x):
        self._changed(user, *joined(self.s.ports[user], vector(x, self.axes), self.s.body))

    def on_packet(self, user, packet):
        """Count what a packet's running sum of energy brings."""
        seen = self._sums[user]
        if seen is not None and seen[0] == packet.epoch:
            self.received_j[user] += max(packet.energy - seen[1], 0.0)
            seen = packet.epoch, max(packet.energy, seen[1])
        else:
            seen = packet.epoch, packet.energy
        self._sums[user] = seen

    def account(self, user):
        return self.s.ports[user].account_j

    def leave(self, user):
        self._changed(user, *left(self.s.ports[user]))

    def _changed(self, user, port, dropped_j):
        ports = (*self.s.ports[:user], port, *self.s.ports[user + 1 :])
        self.s = self.s._replace(ports=ports, dissipated_j=self.s.dissipated_j + dropped_j)

    def step(self, waves):
        """Take a wave of each user (without waves: a position and a velocity), answer each."""
        came = tuple(
            self._came(port, wave, received_j)
            for port, wave, received_j in zip(self.s.ports, waves, self.received_j, strict=True)
        )
        self.s = environment_step(self.p, self.s, came)
        of_users = getattr(self.s.body, "users", ())
        self.faults.note_users((each.there and each.jumped for each in of_users), JUMPED)
        return self.v_s

    def _came(self, port, wave, received_j):
        position, wave = wave if isinstance(wave, tuple) else (value(port.x_s), wave)
        position, wave = vector(position, self.axes), vector(wave, self.axes)
        return Came(wave, position, False, received_j, ())

    def _of_all(self, signal):
        return [value(signal(port)) for port in self.s.ports]

    x_o = property(lambda self: value(self.s.body.x))
    xd_o = property(lambda self: value(self.s.body.xd))
    x_s = property(lambda self: self._of_all(lambda port: port.x_s))
    xd_s = property(lambda self: self._of_all(lambda port: port.avatar.xd))
    f_s = property(lambda self: self._of_all(lambda port: port.avatar.f))
    v_s = property(lambda self: self._of_all(lambda port: port.v_s))
    offset = property(lambda self: self._of_all(lambda port: port.offset))
    present = property(lambda self: [port.avatar.present for port in self.s.ports])
    taken_j = property(lambda self: sum(p.u_j - p.v_j for p in self.s.ports))
    came_j = property(lambda self: sum(p.u_j for p in self.s.ports))
    dissipated = property(lambda self: self.s.dissipated_j)
    stored = property(lambda self: self.energies["kinetic"] + self.energies["potential"])

    def touches(self, user):
        return port_shown(self.p, self.s, user).touches

    @property
    def energies(self):
        """Energies stored, and the accounts [J], by name."""
        counted = scene_energies(self.p, self.s)
        return dict(zip(self._names, counted, strict=False))
