# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A frame of a session as a matrix: the core's own objects, fed with the identity.

Masters, devices and the server of a scenario are set to every unit vector of the state at once (a
batch with one run per state) and stepped through one frame. Frames and server period are equal
here, delays are whole frames. Motions that are no instability are found by what they are, not by
their eigenvalues: null vectors of A - 1, then of the quotient. This shares the stepping with the
simulator and nothing with :mod:`pmwvc_analysis.models`.
"""

import numpy as np
from scipy.linalg import null_space

from pmwvc_core.controllers.ends import make_master, make_server
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.transport.packet import WavePacket


class IdentityLoop:
    """Waves, first-order filter, whole frames of delay, and what stands around the port."""

    def __init__(self, scenario):
        self.scenario, self.users = scenario, scenario.users
        frame_s = scenario.server.period_s
        self.delays = [
            tuple(round(link.delay_s / frame_s) for link in (user.link_up, user.link_down))
            for user in self.users
        ]
        self.names = ["x_o", "xd_o"]
        for i, (up, down) in enumerate(self.delays):
            self.names += [f"{name}{i}" for name in ("x", "xd", "y", "e", "xd_s", "f_s")]
            port = make_master("pmwvc", self.users[i].master).signals()
            self.names += [f"port{i}.{name}" for name in port]
            self.names += [f"up{i}.{age}" for age in range(up)]
            self.names += [f"down{i}.{age}" for age in range(down)]
            self.names += [f"place{i}.{age}" for age in range(down)]

    def frame(self, state):
        """Return the states ``(runs, states)`` a frame later."""
        s = {name: state[:, j : j + 1].copy() for j, name in enumerate(self.names)}
        scenario, tick_s, runs = self.scenario, self.scenario.tick_s, len(state)
        server = make_server(
            "pmwvc",
            scenario.server,
            [user.contact for user in self.users],
            [user.server_impedance for user in self.users],
            dof=1,
            sides=[user.side for user in self.users],
        )
        for i in range(len(self.users)):
            server.join(i, np.zeros((runs, 1)))
        server.body.x, server.body.xd = s["x_o"], s["xd_o"]
        received = []
        for i, port in enumerate(server.ports):
            port.contact.deflection, port.xd_s, port.f_s = s[f"e{i}"], s[f"xd_s{i}"], s[f"f_s{i}"]
            received.append(self._through(s, f"up{i}", self.delays[i][0], s[f"y{i}"]))
        answers = server.step(received)
        s["x_o"], s["xd_o"] = server.body.x, server.body.xd
        for i, (user, port) in enumerate(zip(self.users, server.ports, strict=True)):
            s[f"e{i}"], s[f"xd_s{i}"], s[f"f_s{i}"] = port.contact.deflection, port.xd_s, port.f_s
            master = make_master("pmwvc", user.master)
            device = SimulatedDevice(user.device, tick_s=tick_s, dof=1)
            x, xd = s[f"x{i}"], s[f"xd{i}"]
            device.set_signals({"x": x, "xd": xd, "read.0": x, "read.1": xd})
            master.set_signals({name: s[f"port{i}.{name}"] for name in master.signals()})
            place = self._through(s, f"place{i}", self.delays[i][1], server.x_s[i])
            if user.master.position.is_on:
                self._carry(master, place)
            master.receive(self._through(s, f"down{i}", self.delays[i][1], answers[i]))
            for _ in range(user.master.rate_drop):
                force = master.step(*device.read())
                master.applied(force)
                device.step(0.0, force)
            s[f"x{i}"], s[f"xd{i}"] = device.x, device.xd
            s[f"y{i}"] = master.send()
            s |= {f"port{i}.{name}": value for name, value in master.signals().items()}
        return np.concatenate([s[name] + np.zeros((runs, 1)) for name in self.names], axis=1)

    @staticmethod
    def _carry(master, place):
        """Give a position feedback the position of the avatar."""
        master.on_packet(WavePacket(1, 1, 0, 1.0, 0.0, 0.0, 0.0, place))
        master.restore({**master.snapshot(), "position.error.reference": 0.0})

    @staticmethod
    def _through(s, link, delay, value):
        """Put a value into a link and return the one that comes out."""
        values = [value, *(s[f"{link}.{age}"] for age in range(delay))]
        for age in range(delay):
            s[f"{link}.{age}"] = values[age]
        return values[-1]

    def spectral_radius(self):
        """Return the largest length of an eigenvalue, rigid motions taken out."""
        a = self.frame(np.eye(len(self.names))).T
        tied = any(user.master.position.gain > 0.0 for user in self.users)
        moving = (
            not tied or self.users[0].master.rate_drop == 1
        )  # received in steps: no such motion
        for _ in range(1 + moving):  # translations, then what moves on with them uniformly
            still = null_space(a - np.eye(len(a)), rcond=1e-11)
            basis, _ = np.linalg.qr(np.hstack([still, np.eye(len(a))]), mode="reduced")
            k = still.shape[1]
            a = (basis.T @ a @ basis)[k:, k:]
        return np.abs(np.linalg.eigvals(a)).max()
