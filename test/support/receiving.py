# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The ends of a link by themselves: the receiver, with the law of the channel for what it accepts;
the sender with its deadband; and a playout.
"""

import math

import numpy as np

from pmwvc_core.ends.inbox import Inbox, message, value, vector
from pmwvc_core.law.channel import arrivals, playout
from pmwvc_core.law.channel.arrivals import ArrivalsParams, anew, arrive, start_of, wave_of
from pmwvc_core.law.channel.constants import SETTLE_S
from pmwvc_core.law.channel.packet import Packing, Sent, pack
from pmwvc_core.law.channel.playout import Energies, PlayoutParams
from pmwvc_core.made.user import packing_params
from pmwvc_core.numeric import AXES
from pmwvc_core.params import DeadbandParams
from pmwvc_core.quaternions import IDENTITY
from support.session_given import session_given


class ReceivingEnd:
    """What has come in at one end, and the wave given out."""

    def __init__(
        self,
        channel,
        dof=1,
        *,
        period_s,
        timeout_s,
        longest=math.inf,
        inbox=Inbox,
        most_repaid=1.0,
        store_j=0.0,
    ):
        times = {"period_s": period_s, "timeout_s": timeout_s}
        self.inbox = inbox(
            session_given(channel=channel, dof=dof), 25.0, from_server=False, **times
        )
        self.inbox.max_wave = longest
        played = PlayoutParams(most_repaid, SETTLE_S, store_j)
        strict, once = channel == "strict", channel == "zeroing"
        self.p = ArrivalsParams(timeout_s, longest, once, strict, played)
        self.s = start_of(strict, dof, timeout_s, period_s)

    def push(self, packet, now_ns):
        """Take a packet; return it as the laws have it, None where it is refused."""
        for taken in self.inbox.take([packet], now_ns):
            self.s = arrive(self.s, taken, now_ns, self.p)
            self.inbox.silence_ns = self.s.silence.limit_ns
            return taken
        return None

    def step(self, h):
        """Return the wave of the next h seconds [sqrt(W)]."""
        self.s, wave = wave_of(self.s, h, self.p)
        return value(wave)

    def anew(self):
        """Let the sender be placed anew by its newest packet."""
        self.s = anew(self.s)

    playout = property(lambda self: self.s.playout)
    moved = property(lambda self: self.s.playout.moved)
    waiting = property(lambda self: value(playout.waiting(self.s.playout)))
    free_j = property(lambda self: playout.free_j(self.s.playout))


class SendingEnd:
    """The samples of a sender."""

    def __init__(self, dof=1, *, period_s, **deadband):
        self.dof, self.period_s = dof, period_s
        self.s, self.p = Packing(*((0.0,) * dof,) * 3), packing_params(DeadbandParams(**deadband))

    def send(self, wave, now_ns=0, *, anew=False):
        """Add a sample; return its packet, None where the deadband holds it back."""
        sent = Sent(vector(wave, self.dof), (0.0,) * self.dof, -1.0, (), 0)
        says = now_ns, (False, False), anew, False, 0, 0
        self.s, packet, sends = pack(self.s, sent, self.period_s, *says, self.p)
        turned = IDENTITY if self.dof == AXES else ()
        return message(packet, 1, 0, (0, 0, 0), turned) if sends else None


class Playing:
    """A playout; waves are floats or ``(dof,)``."""

    def __init__(self, dof=1, *, steps=1, most_repaid=1.0, rises_s=SETTLE_S, **lends):
        self.dof, self.p = dof, PlayoutParams(most_repaid, rises_s, **{"store_j": 0.0, **lends})
        self.s = playout.ramped(playout.resting_playout((0.0,) * dof, Energies()), steps)

    def add(self, integral, energy_j, duration_s):
        of = vector(integral, self.dof), float(np.ravel(energy_j)[0]), duration_s
        self.s = playout.add(self.s, *of, self.p.store_j)

    def step(self, h):
        self.s, wave = playout.play(self.s, h, self.p)
        return value(wave)

    def spared(self, h, wanted, beyond_j=0.0):
        self.s, energy_j = arrivals.spared(self.s, h, bool(wanted), beyond_j, self.p)
        return energy_j

    def pass_by(self, lasted_s):
        self.s = playout.pass_by(self.s, lasted_s)

    def begin(self):
        self.s = playout.begin(self.s)

    def give(self, given_j):
        """Let so much have been given out [J]."""
        self.s = self.s._replace(moved=self.s.moved._replace(given_j=given_j))

    received_j = property(lambda self: self.s.moved.received_j)
    given_j = property(lambda self: self.s.moved.given_j)
    released_j = property(lambda self: self.s.moved.released_j)
    discarded_j = property(lambda self: self.s.moved.discarded_j)
    free_j = property(lambda self: playout.free_j(self.s))
    waiting = property(lambda self: value(playout.waiting(self.s)))
    undelivered = property(lambda self: value(self.s.undelivered))
