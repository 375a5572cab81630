# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both laws of a plug-in without waves, a device that is moved as prescribed, an avatar at a wall
that may move, and a link that delays and loses packets: what comes of it at both ports.

Energy is counted here, from forces and ways alone. The prescribed motion is a straight line within
each tick.
"""

from benchmark.rivals import (
    deadband_tdpa,
    energy_bounding,
    four_channel,
    iss_damping,
    model_mediated,
    two_layer,
)

from pmwvc_core.controllers.plugged import AvatarStep, DeviceTick
from pmwvc_core.law.channel.packet import no_packet
from pmwvc_core.law.motion import Body
from pmwvc_core.law.server.contacts import Contact, slid
from pmwvc_core.law.server.springs import ContactLaw, Spring

TICK_S, M = 0.001, 8
FRAME_S = M * TICK_S


class RivalLink:
    """Two ends of one axis; ``late(n)`` gives the delay of packet n [frames], None where lost."""

    def __init__(
        self, record, p=None, *, late=lambda n: 0, stiffness=500.0, damping=10.0, grip=True
    ):
        self.record, self.p, self._late = record, p or record.params(), late
        self.device, self.avatar = record.device_rest(self.p, 1), record.avatar_rest(self.p, 1)
        law = ContactLaw(stiffness, damping, 1.0, 0.0, 0.0)
        self.contact = Contact(law, (Spring(0.0, 0.0, grip),))
        self.x = self.force = self.x_s = self.xd_s = self.f_s = self.wall = 0.0
        up, down = record.extra(1)
        self.nothing = no_packet((0.0,), (0.0,) * down)
        self.answer = (0.0,), (0.0,) * up
        self.ways = {"up": [], "down": []}
        self.heard = {"up": None, "down": None}
        self.n = 0
        self.work_j = 0.0  # put in at the device
        self.out_j = 0.0  # given out at the avatar; and all that it took in
        self.taken_j = 0.0

    def _pass(self, way, wave, position, extra):
        """Send a packet and return the newest that has come."""
        late = self._late(self.n)
        if late is not None:
            packet = self.nothing._replace(
                number=self.n + 1, period_s=FRAME_S, wave=wave, position=position, extra=extra
            )
            self.ways[way].append((self.n + late, packet))
        here = [packet for at, packet in self.ways[way] if at <= self.n]
        self.ways[way] = [one for one in self.ways[way] if one[0] > self.n]
        known = [one for one in (self.heard[way], *here) if one is not None]
        self.heard[way] = max(known, key=lambda one: one.number) if known else None
        return self.heard[way]

    def frame(self, velocities, wall=0.0):
        """Run a frame: the device moves at these velocities [m/s], the wall to a place [m]."""
        came = self._pass("up", self.answer[0], (self.x,), self.answer[1])
        if came is not None:
            self._pass("down", *self._avatar(came, wall))
        packet = self.heard["down"] or self.nothing
        for number, xd in enumerate(velocities):
            tick = DeviceTick((self.x,), (xd,), packet, False, number == 0, (self.force,), TICK_S)
            self.device, answer = self.record.device(self.device, tick, self.p)
            (self.force,), self.answer = answer.force, (answer.wave, answer.extra)
            self.work_j += self.force * xd * TICK_S
            self.x += xd * TICK_S
        self.n += 1

    def _avatar(self, came, wall):
        moved, self.wall = wall - self.wall, wall
        self.contact, _ = slid(self.contact, (-moved,))
        before = self.xd_s if self.record.coupling.moves == "forward_euler" else None
        step = AvatarStep(
            came.position, came.wave, came.extra, (self.x_s,), (self.xd_s,), (self.f_s,),
            self.contact, Body((wall,), (moved / FRAME_S,)), FRAME_S, (0.0,),
        )  # fmt: skip
        self.avatar, answer = self.record.avatar(self.avatar, step, self.p)
        (x_s,), (xd,), (f,), self.contact, _ = answer.moved
        way = FRAME_S * (xd if before is None else before)
        assert abs(x_s - self.x_s - way) < 1e-9  # the velocity is that of the way
        self.x_s, self.xd_s, self.f_s = x_s, xd, f
        out_j = FRAME_S * f * xd
        self.out_j, self.taken_j = self.out_j + out_j, self.taken_j + max(-out_j, 0.0)
        return answer.wave, (x_s,), answer.extra

    def go(self, way_m, frames):
        """Move the device evenly by a way."""
        for _ in range(frames):
            self.frame([way_m / (frames * FRAME_S)] * M, self.wall)

    @property
    def balance_j(self):
        """Energy put in at both ports: what the link has stored or dissipated."""
        return self.work_j - self.out_j


RECORDS = {
    record.name: (record, module)
    for record, module in (
        (two_layer.TWO_LAYER, two_layer),
        (model_mediated.MODEL_MEDIATED, model_mediated),
        (iss_damping.ISS_DAMPING, iss_damping),
        (energy_bounding.ENERGY_BOUNDING, energy_bounding),
        (four_channel.FOUR_CHANNEL_TDPA, four_channel),
        (deadband_tdpa.DEADBAND_TDPA, deadband_tdpa),
    )
}
K = 500.0  # [N/m] of the contact


def made(name, **values):
    record, _ = RECORDS[name]
    return record, record.params(**values)


def series(*stiffnesses):
    return 1.0 / sum(1.0 / each for each in stiffnesses)
