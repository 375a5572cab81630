# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A second model of the master's end of the strict channel and of its limits, written from
theory.md section 17 (17.4, 17.5, 17.10, 17.12, 17.19, 17.23, 17.27, 17.28) and 10.2: no port
filters.
"""

import math
from types import SimpleNamespace

import numpy as np
from oracle.strict_encoder_model import Encoder
from oracle.strict_playout_model import PlayedWave
from oracle.strict_receiver_model import Friction, Receiver

from pmwvc_core.transport.packet import FLAG_SHORT

KEPT_J, SAFE_J = 1e-4, 2e-3


class Spring:
    """17.12: the brake at the device, z <- z + dx, F = k z below the friction."""

    def __init__(self, b, h):
        self.k, self.friction, self.z, self.x = b / 0.0125, Friction(h, 0.2), 0.0, 0.0

    @property
    def stored_j(self):
        return 0.5 * self.k * float(np.sum(self.z * self.z))

    def let_go(self):
        self.friction.release()
        self.z = 0.0 * self.z

    def move(self, waits, x, force):
        moved, self.x = x - self.x, x
        self.friction.step(waits, force)
        self.z = self._within(self.z + moved) if self.friction.acts else 0.0 * x

    def _within(self, z):
        size = self.k * math.sqrt(z @ z)
        return z * (self.friction.limit / size) if size > self.friction.limit else z

    def pull(self, beside):
        """The force that keeps |beside + F| <= the friction, or F no larger than before."""
        force = self.k * self.z
        room = max(self.friction.limit**2 - beside @ beside, 0.0)
        along, size = beside @ force, force @ force
        if 2.0 * along + size > room:
            part = (math.sqrt(along * along + size * room) - along) / size
            force = force * min(max(part, 0.0), 1.0)
        self.z = force / self.k
        return force


class Limits:
    """10.2: soft start, damping in a silence, largest force and slew, with a brake."""

    def __init__(self, spring, *, h, soft_s, release_s, most_n, slew_n):
        self.spring, self.h, self.soft_s, self.release_s = spring, h, soft_s, release_s
        self.most_n, self.slew_n = most_n, slew_n
        self.f, self.part, self.rest = 0.0, 0.0, 1.0
        self.old, self.fading_s = 0.0, 0.0
        self.ready = self.was_damped = self.rises_again = self.by_silence = False

    def restart(self):
        self.part, self.rises_again, self.by_silence = 0.0, False, False
        self.old, self.fading_s = self.f, 0.02
        self.spring.let_go()

    def pass_on(self, f, x, xd, *, coupled, silence_s, silent_after_s, interrupted):
        self.spring.move(interrupted, x, self.f + 0.0 * x)
        gone = coupled and silence_s > self.release_s
        damped = coupled and silence_s > silent_after_s and (interrupted or gone)
        self._ratios(coupled, damped, damped and gone)
        if self.spring.friction.acts:
            f = f + self.spring.pull(f)
        self.fading_s = max(self.fading_s - self.h, 0.0) if coupled else 0.0
        old = self.fading_s / 0.02
        f = self.part * f * (1.0 - old) + self.old * old
        size = math.sqrt(f @ f)
        wanted = f * (self.most_n / size) if size > self.most_n else f
        change = wanted - self.f
        size = math.sqrt(change @ change)
        self.f = self.f + change * (self.slew_n / size) if size > self.slew_n else wanted
        return self.f

    def _ratios(self, coupled, damped, released):
        back = self.was_damped and not damped
        after_silence = self.by_silence and self.ready
        if back:
            self.rises_again = after_silence
        self.rises_again = self.rises_again and coupled
        if back and not after_silence:
            self.part *= self.rest
        soft_s = min(self.soft_s, 0.1) if self.rises_again else self.soft_s
        if released:
            self.part = max(self.part - self.h / 0.5, 0.0)
        else:
            self.part = min(self.part + self.h / soft_s, 1.0)
        self.part = self.part if coupled else 0.0
        self.ready = self.ready or (self.part >= 1.0 and not damped)
        self.rest = max(self.rest - self.h / 0.02, 0.0) if damped else 1.0
        self.was_damped = self.by_silence = damped


class MasterModel:
    """One end, stepped as the frame protocol says: packet, arrivals, answer, tick."""

    def __init__(self, *, dof, b, h, rate_drop, store_j, server_s, timeout_s, limits, rises=1.0):
        longest = (20.0 + 20.0 * b) / math.sqrt(2.0 * b)
        self.dof, self.b, self.h, self.frame = dof, b, h, rate_drop
        self.root = math.sqrt(2.0 * b)
        self.steps = max(round(server_s / h), 1)
        repaid = {"fastest_repaid": 0.06 * math.sqrt(b / 2.0), "grows_s": 0.2}
        self.wave = PlayedWave(dof, lent_once_j=store_j, steps=self.steps, **repaid)
        self.rises, self.level, self.more = rises, 0, 0.0
        self.inbox = Receiver(
            dof, self.wave, period_s=server_s, timeout_s=timeout_s, longest_wave=longest
        )
        self.spring = Spring(b, h)
        self.limits = Limits(self.spring, h=h, **limits)
        self.least_silence_s = self.silent_after_s = max(timeout_s, 3.0 * server_s)
        self.encoder, self.xd = Encoder(dof, h), None
        self.node_j = self.paid_j = self.unpaid = self.deficit_j = self.withheld_j = 0.0
        self.u = np.zeros(dof)  # integral since the last packet
        self.total, self.seq, self.next_frame, self.due = np.zeros(dof), 0, 0, math.inf
        self.force = None
        self.asked_for = self.short = self.heard = False
        self.v = np.zeros(dof)
        self.f = np.zeros(dof)

    def tick(self, k, now_ns, x, xd, packets):
        """Return the packet (or None), the force asked for and applied, and the wave v."""
        packet, answers = None, False
        if k >= self.next_frame:
            self._close(x, xd)
            packet, answers = self._packet(), True
            self.next_frame = k - k % self.frame + self.frame
        if (k - self.due) * self.h > 0.02:  # it stood still
            self.limits.old, self.limits.fading_s = self.limits.f, 0.02
        for each in packets:
            _, begins = self.inbox.take(each, now_ns)
            if begins and self.heard:  # another server
                self.limits.restart()
            self.heard = self.heard or begins
        if answers:
            self._answer()
        if k > self.due:
            self.wave.stand_still((k - self.due) * self.h)
        self.due = k + 1
        self._close(x, xd)
        wanted = 1.0 + (self.rises - 1.0) * self.level / 255.0
        self.wave.raised += (wanted - self.wave.raised) / self.steps
        v = self.wave.play(self.h)
        if self.node_j < 0.0:
            self.node_j += self.wave.hand_out(-self.node_j)
            if self.node_j < -SAFE_J - self.withheld_j:  # the wave waits until the hand has paid
                self.wave.out_j -= 0.5 * self.h * self.wave.raised * float(v @ v)
                self.wave._owe(v * self.h)
                v = 0.0 * v
        more = min(0.3 * self.deficit_j / 1e-3, 0.3)
        if self.asked_for or self.short:
            more += min(max(self.unpaid / 0.03, 0.2), 1.0)
        self.more += (more - self.more) * min(self.h / 0.03, 1.0)
        asked = (
            self.wave.raised * (self.b * self.xd - self.root * v) + self.more * self.b * self.xd
        )
        known = self.inbox.last is not None
        silence_s = (now_ns - self.inbox.at_ns) * 1e-9 if known else math.inf
        self.f = self.limits.pass_on(
            asked,
            x,
            xd,
            coupled=known,
            silence_s=silence_s,
            silent_after_s=self.silent_after_s,
            interrupted=known and self.inbox.interrupted(now_ns),
        )
        self.v, self.force = v, self.f
        return packet, asked, self.f, math.sqrt(self.wave.raised) * v

    def _close(self, x, xd):
        """17.4 and 17.5: what the tick before moved and brought."""
        if self.force is None:
            if self.due == math.inf:  # nothing has moved yet
                self.encoder.begin(x)
                self.xd = xd
            return
        force, self.force = self.force, None
        dx, moved, velocity = map(np.array, self.encoder.step(x, xd))
        self.xd = velocity
        self.u = self.u + self.root * dx - self.v * self.h
        self.node_j += 0.5 * self.h * self.wave.raised * float(self.v @ self.v)
        self.node_j += float(force @ moved)

    def _answer(self):
        last = self.inbox.last
        if last is None:
            return
        if self.asked_for and not last.flags & FLAG_SHORT:
            self.unpaid = 0.0
        self.level = last.flags >> 8
        self.asked_for, self.short = bool(last.flags & FLAG_SHORT), self.wave.lacks
        self.silent_after_s = max(self.least_silence_s, self.inbox.silence_ns * 1e-9)

    def _packet(self):
        lasts_s = self.frame * self.h
        wave, self.u = self.u / lasts_s, np.zeros(self.dof)
        needs_j = 0.5 * lasts_s * self.wave.raised * float(wave @ wave)
        counts = not self.encoder.exact
        if counts:
            held = self.wave.raised * sum(
                self.b * axis.rough**2 / self.h for axis in self.encoder.axes
            )
            self.node_j += self.withheld_j - held
            self.withheld_j = held
        self.node_j += self.wave.surplus(
            lasts_s, asked_for=self.asked_for, of_e0=self.unpaid > 5e-4
        )
        own_j = self.node_j - self.spring.stored_j
        paid_j = max(min(own_j, needs_j), own_j - KEPT_J, 0.0)
        if counts:
            paid_j = max(paid_j, min(own_j, needs_j + self.deficit_j))
            short_j = needs_j - paid_j
            lacking_j = self.deficit_j + short_j + max(short_j, 0.0)
            self.deficit_j = min(max(lacking_j, 0.0), 0.01) if self.withheld_j > 0.0 else 0.0
        if paid_j < needs_j and self.withheld_j <= 0.0:
            self.unpaid += (1.0 - math.sqrt(paid_j / needs_j)) * math.sqrt(wave @ wave) * lasts_s
        self.paid_j += paid_j
        self.node_j -= paid_j
        self.total = self.total + wave * lasts_s
        self.seq += 1
        return SimpleNamespace(
            seq=self.seq,
            wave=wave,
            integral=self.total,
            energy=self.paid_j,
            waiting=self.wave.tells_the_other,
            short=self.wave.lacks,
            period=lasts_s,
        )
