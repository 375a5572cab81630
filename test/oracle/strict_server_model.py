# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A second model of the server's end of the strict channel, written from theory.md 4.3 to 4.5,
17.13, 17.19, 17.20 and 17.28: users around a cube or a wall, solved together by the midpoint rule.

A two-sided contact is solved in closed form; a grip is two nested searches for a root.
"""

import math
from types import SimpleNamespace

import numpy as np
from oracle.strict_contact_model import NARROW, Spring
from oracle.strict_playout_model import PlayedWave
from oracle.strict_receiver_model import Friction, Receiver
from scipy.optimize import brentq

from pmwvc_core.transport.packet import FLAG_SHORT

FLAG_LEAVING, FLAG_ANEW = 2, 8


class UserModel:
    """One user's port, its brake, and what it receives."""

    def __init__(self, dof, contact, *, b, store_j, frame_s, timeout_s, h, rises=1.0):
        self.dof, self.contact, self.b = dof, contact, b
        self.wave = PlayedWave(
            dof, lent_once_j=store_j, fastest_repaid=0.06 * math.sqrt(b / 2.0), grows_s=0.1
        )
        longest = (20.0 + 20.0 * b) / math.sqrt(2.0 * b)
        self.inbox = Receiver(
            dof, self.wave, period_s=frame_s, timeout_s=timeout_s, longest_wave=longest
        )
        self.friction = Friction(h, 0.1)
        self.there, self.anew, self.seq = False, 0, 0
        self.offset, self.f, self.heat_j = np.zeros(dof), np.zeros(dof), 0.0
        self.sent, self.sent_j = np.zeros(dof), 0.0
        self.in_j = self.back_j = 0.0
        self.rises, self.level, self.touched_s = rises, 0.0, 0.0

    def follow(self, h):
        """17.28: the impedance of this step, over b."""
        if self.rises > 1.0:
            self.touched_s = 0.06 if self.f @ self.f > 0.05**2 else max(self.touched_s - h, 0.0)
            self.level += 255.0 * (h / 0.1 if self.touched_s > 0.0 else -h / 0.05)
            self.level = min(max(self.level, 0.0), 255.0)
        self.wave.raised = 1.0 + (self.rises - 1.0) * int(self.level) / 255.0

    def firmness(self, u):
        """17.13: N of this step."""
        limit = self.friction.limit
        left = self.f - math.sqrt(2.0 * self.b * self.wave.raised) * u
        size = math.sqrt(left @ left)
        if limit <= 0.0 or left @ self.f <= 0.0:
            return 1.0
        return min(size / (size - limit), 1000.0) if size > limit else 1000.0


class ServerModel:
    """All users, stepped together."""

    def __init__(self, users, *, dof, h, mass, damping, release_s):
        self.users, self.dof, self.h, self.release_s = users, dof, h, release_s
        self.mass, self.damping = mass, damping  # mass None: a wall
        self.x, self.xd, self.lost_j = np.zeros(dof), np.zeros(dof), 0.0

    @property
    def stored_j(self):
        moving = 0.5 * self.mass * float(self.xd @ self.xd) if self.mass else 0.0
        return moving, sum(user.contact.stored_j for user in self.users if user.there)

    def step(self, now_ns, packets, missed_s):
        for user, arrived in zip(self.users, packets, strict=True):
            there = user.there
            user.follow(self.h)
            for packet in arrived:
                self._take(user, packet, now_ns)
            if missed_s > 0.0 and there:
                user.wave.stand_still(missed_s)
        ports = [self._port(user, now_ns) for user in self.users]
        present = [port for port in ports if port.user.there]
        before = sum(self.stored_j)
        self._solve(present)
        for port in present:
            self._give(port)
        inward = sum(self._net(port.u1) - self._net(port.v1) for port in present)
        self.lost_j += inward - (sum(self.stored_j) - before)
        for port in present:
            self._slide(port.user)
        return [self._answer(port, now_ns) for port in ports]

    def _take(self, user, packet, now_ns):
        counts, begins = user.inbox.take(packet, now_ns)
        if not counts:
            return
        if packet.flags & FLAG_LEAVING:
            self._leave(user)
        elif begins or not user.there:
            self._leave(user)
            position = np.array(packet.position, float).reshape(-1)
            user.contact.meet(position - self.x)
            user.offset = self.x + user.contact.at + user.contact.e - position
            user.wave.begin()
            user.anew ^= FLAG_ANEW
            user.there = True

    def _leave(self, user):
        if user.there:
            self.lost_j += user.contact.stored_j
            user.contact.part()
            user.friction.release()
            user.f, user.there = np.zeros(self.dof), False

    def _port(self, user, now_ns):
        """The port as the coupling sees it: impedance N b, wave u/sqrt(N)."""
        u = math.sqrt(user.wave.raised) * user.wave.play(self.h)
        if user.there and (now_ns - user.inbox.at_ns) * 1e-9 > self.release_s:
            self._leave(user)
        port = SimpleNamespace(user=user, u=u, n=1.0, v=np.zeros(self.dof), lasting=0.0)
        if user.there:
            silent = user.inbox.silent(now_ns) and user.inbox.interrupted(now_ns)
            port.damped = silent or user.inbox.unheard(now_ns)
            user.friction.step(user.inbox.interrupted(now_ns), user.f)
            port.n = user.firmness(u)
        port.b, port.u1 = port.n * user.b * user.wave.raised, u / math.sqrt(port.n)
        port.free = math.sqrt(2.0 / port.b) * port.u1
        return port

    def _forces(self, ports, v):
        return [port.user.contact.force(port.free - v, port.b, self.h) for port in ports]

    def _solve(self, ports):
        """4.4: m (v1 - v0)/h + b_o v = sum of forces, v the mean velocity of the object."""
        v, inertia = np.zeros(self.dof), 2.0 * (self.mass or 0.0) / self.h
        if self.mass:
            v = self._velocity(ports, inertia)
            self.x, self.xd = self.x + self.h * v, 2.0 * v - self.xd
        for port, force in zip(ports, self._forces(ports, v), strict=True):
            port.user.f = force
            port.user.contact.e = port.user.contact.e + self.h * (port.free - force / port.b - v)
            port.v1 = port.u1 - math.sqrt(2.0 / port.b) * force

    def _velocity(self, ports, inertia):
        def missing(v):
            v = np.atleast_1d(v)
            pushes = sum(self._forces(ports, v), np.zeros(self.dof))
            return inertia * (v - self.xd) + self.damping * v - pushes

        rest = missing(np.zeros(self.dof))
        if all(isinstance(port.user.contact, Spring) for port in ports):
            return -rest / (missing(np.ones(self.dof)) - rest)  # linear, axis by axis
        reach = -1.01 * rest[0] / (inertia + self.damping)  # contacts only add to the slope
        if reach == 0.0:
            return np.zeros(1)
        return np.array([brentq(lambda v: missing(v)[0], 0.0, reach, **NARROW)])

    def _net(self, wave):
        return 0.5 * self.h * float(wave @ wave)

    def _give(self, port):
        """17.13: the wave in front of the damper, and its heat."""
        port.v = (port.u1 + port.v1) / math.sqrt(port.n) - port.u
        through = self._net(port.u1) - self._net(port.v1)
        port.user.heat_j += self._net(port.u) - self._net(port.v) - through

    def _slide(self, user):
        """17.20: the avatar outside the face comes closer to its device, at most 0.1 m/s."""
        away = math.sqrt(user.offset @ user.offset)
        if away > 0.0:
            wanted = -user.offset * min(0.1 * self.h / away, 1.0)
            moved = user.contact.room(wanted)
            user.contact.e, user.offset = user.contact.e + moved, user.offset + moved

    def _packet(self, user, **signals):
        user.seq += 1
        signals |= {"seq": user.seq, "integral": user.sent, "energy": user.sent_j}
        signals |= {"waiting": user.wave.tells_the_other, "anew": user.anew}
        return SimpleNamespace(asks=not user.there, **signals)

    def _answer(self, port, now_ns):
        user, zero = port.user, np.zeros(self.dof)
        if not user.there:  # nothing, or that it shall prove itself
            asks = user.inbox.asks_for_proof(now_ns)
            return self._packet(user, wave=zero, position=zero) if asks else None
        passed_j = user.wave.surplus(self.h, asked_for=bool(user.inbox.last.flags & FLAG_SHORT))
        user.in_j += self._net(port.u) + passed_j
        user.back_j += self._net(port.v) + passed_j
        wave = port.v / math.sqrt(user.wave.raised)
        user.sent = user.sent + wave * self.h
        user.sent_j += self._net(port.v) + passed_j
        x_s = self.x + user.contact.at + user.contact.e
        found = self._packet(user, wave=wave, position=x_s - user.offset)
        found.short, found.x_s, found.u, found.damped = user.wave.lacks, x_s, port.u, port.damped
        return found
