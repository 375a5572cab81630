# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One device that is moved as prescribed, one avatar at a fixed spring, and a lossy link between
them: what a controller without waves does with energy, seen from its two ports.

The prescribed motion is a straight line within each tick, so force times velocity at the tick is
the work done in it.
"""

import numpy as np

from pmwvc_core.params import BaselineParams, ContactParams, MasterParams, ServerParams
from support.law_rigs import Users
from support.packer import Packer
from support.port_rig import Port

TICK_S = 0.001
M = 8
FRAME_S = TICK_S * M


class BaselineLink:
    """Both ends, and every packet on its way."""

    def __init__(
        self,
        controller,
        *,
        baseline=None,
        stiffness=500.0,
        damping=0.0,
        delay_frames=2,
        lost=lambda way, n: False,
        contact="bilateral",
        zero=0.0,
    ):
        baseline = baseline or BaselineParams()
        axes = np.size(zero)
        self.master = Port(
            MasterParams(rate_drop=M), controller=controller, baseline=baseline, axes=axes
        )
        self.server = Users(
            ServerParams(environment="wall", period_s=FRAME_S),
            [ContactParams(contact=contact, contact_stiffness=stiffness, contact_damping=damping)],
            controller=controller,
            baseline=baseline,
            sides=[-1],
            axes=axes,
        )
        self.packers = {"up": Packer(1, period=FRAME_S), "down": Packer(2, period=FRAME_S)}
        self.flying = {"up": [], "down": []}
        self.newest = {"up": None, "down": None}
        self.delay, self.lost, self.n = delay_frames, lost, 0
        self.x = zero
        self.work_m = 0.0 * np.sum(zero)  # [J] put in at the device's port
        self.work_s = 0.0 * np.sum(zero)  # [J] put in at the avatar's port
        self.force = zero

    def _send(self, way, values, position, energy):
        packet = self.packers[way].pack(*values, position, self.n, energy=energy)
        if not self.lost(way, self.n):
            self.flying[way].append((self.n + self.delay, packet))

    def _take(self, way):
        due = [p for n, p in self.flying[way] if n <= self.n]
        self.flying[way] = [(n, p) for n, p in self.flying[way] if n > self.n]
        self.newest[way] = due[-1] if due else self.newest[way]
        return self.newest[way]

    def frame(self, velocities, change=lambda f: f):
        """Run a frame in which the device moves at these velocities, one a tick [m/s]."""
        master, server = self.master, self.server
        master.measure(self.x, velocities[0])
        wave = master.send()
        self._send("up", (wave,), master.x, master.account)
        heard = self._take("up")
        if heard is not None:
            if not server.present[0]:
                server.join(0, heard.position)
            server.on_packet(0, heard)
            answer = server.step([(heard.position, heard.wave)])[0]
            self.work_s -= FRAME_S * float(np.sum(server.f_s[0] * server.xd_s[0]))
            self._send("down", (answer,), server.x_s[0], server.account(0))
        answer = self._take("down")
        if answer is None:
            master.silence()
        else:
            master.on_packet(answer)
            master.receive(answer.wave)
        for velocity in velocities:
            self.force = change(master.step(self.x, velocity))
            master.applied(self.force)
            self.work_m = self.work_m + TICK_S * np.sum(self.force * velocity)
            self.x = self.x + TICK_S * velocity
        master.measure(self.x, velocities[-1])
        self.n += 1

    @property
    def balance(self):
        """Energy put in at both ports [J]: what the link has stored or dissipated."""
        return self.work_m + self.work_s
