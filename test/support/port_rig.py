# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A user's port with its state, stepped on floats, or on arrays where a test has several axes."""

from dataclasses import replace

import pmwvc_core.law.port.strict_master  # noqa: F401  # joins the families
from pmwvc_core.controllers.library import accounts_of_user
from pmwvc_core.ends.inbox import known, value, vector
from pmwvc_core.law.channel.arrivals import arrive
from pmwvc_core.law.channel.playout import add
from pmwvc_core.law.port.master import (
    port_answer,
    port_energies,
    port_measure,
    port_passed,
    port_send,
    port_signals,
    port_tick,
)
from pmwvc_core.law.position.feedback import position_in
from pmwvc_core.made.user import changed_user, made_user
from pmwvc_core.params import ServerParams
from pmwvc_core.scenario.scenario import User
from support.session_given import session_given

FIRST = ("u_m", "u_tx", "v_rx", "v_m")


class Port:
    """The device's end of a controller without the limits and without packets."""

    def __init__(self, master, *, controller="pmwvc", channel="plain", axes=1, baseline=None):
        own = {} if baseline is None else {"baseline": baseline}
        self._user, self.axes = User("user1", master=master, **own), axes
        server = ServerParams(period_s=master.frame_s)
        self._session = session_given(
            controller=controller, channel=channel, dof=axes, server=server
        )
        self.user, self.p = made_user(self._user, self._session)
        self.arrivals, self.s = self.user.arrivals, self.user.port
        self._number, self._epoch = 0, None
        self._newest, self.account = self.user.newest, 0.0

    def configure(self, master):
        old, self._user = self._user, replace(self._user, master=master)
        wanted, s = made_user(self._user, self._session), self.user._replace(port=self.s)
        s, self.p = changed_user(s, self.p, wanted, old, self._user)
        self.s = s.port

    def measure(self, x, xd):
        self.s = port_measure(self.s, vector(x, self.axes), vector(xd, self.axes), self.p.port)

    def send(self):
        """Return the wave that leaves at a frame start."""
        self._number += 1
        frame_s = self._user.master.frame_s
        self.s, self.arrivals, self.sent = port_send(
            self.s, self.arrivals, frame_s, self._number, 0.0, self.p.port
        )
        self.account = self.sent.energy_j  # running sum for the packet; below zero: none
        return value(self.sent.wave)

    def receive(self, wave):
        """Take a wave that stands for the frame that begins."""
        self._answered(vector(wave, self.axes), False)

    def silence(self):
        self._answered((1.0,) * self.axes, True)  # a wave that does not count

    def _answered(self, wave, silent):
        given = self.arrivals, self._newest, wave, silent, self._user.master.frame_s
        self.s = port_answer(self.s, *given, self.p.port)

    def step(self, x, xd):
        """Return the force that a tick asks for [N]."""
        x, xd = vector(x, self.axes), vector(xd, self.axes)
        self.s, self.arrivals, f = port_tick(self.s, self.arrivals, x, xd, self.p.port)
        return value(f)

    def applied(self, f):
        self.s = port_passed(self.s, vector(f, self.axes), self.p.port)

    def tick(self, xd, x=0.0):
        f = self.step(x, xd)
        self.applied(f)
        return f

    def on_packet(self, packet, lost=0):
        """Take an accepted packet in, before its wave."""
        fresh = packet.epoch != self._epoch
        self._epoch = packet.epoch
        came = known(packet, self.axes, fresh=fresh, lost=lost)._replace(extra=())
        self.arrivals = arrive(self.arrivals, came, 0, self.p.arrivals)
        self._newest = came
        if hasattr(self.arrivals, "playout"):  # which has the wave
            self.receive(0.0)

    def settle(self):
        """Have position feedback settle the frame that ends, by the newest packet once more."""
        of = self.s.position, self._newest, True, self.p.port.position
        self.s = self.s._replace(position=position_in(*of))

    def come(self, integral, energy_j, duration_s):
        """Take a segment of the strict channel in."""
        integral = vector(integral, self.axes)
        store_j = self.p.arrivals.playout.store_j
        self.playout = add(self.playout, integral, energy_j, duration_s, store_j)

    @property
    def playout(self):
        return self.arrivals.playout

    @playout.setter
    def playout(self, playout):
        self.arrivals = self.arrivals._replace(playout=playout)

    u_m = property(lambda self: value(port_signals(self.s)[0]))
    u_m_lp = property(lambda self: value(port_signals(self.s)[1]))
    v_m = property(lambda self: value(port_signals(self.s)[2]))
    x = property(lambda self: value(getattr(self.s, "motion", self.s).x))

    @property
    def energies(self):
        """Energies since the start [J] by name."""
        session, master = self._session, self._user.master
        own = accounts_of_user(session.controller, session.channel, master)
        names = (*FIRST, *(entry.name for entry in own))
        return dict(zip(names, port_energies(self.s, self.arrivals, self.p.port), strict=False))
