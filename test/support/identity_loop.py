# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A frame of a session as a matrix: the core's own laws, fed with the identity.

Ports, devices and the server of a scenario are set to every unit vector of the state, one after
the other, and stepped through one frame. Frames and server period are equal here, delays are whole
frames. Motions that are no instability are found by what they are, not by their eigenvalues: null
vectors of A - 1, then of the quotient. This shares the stepping with the simulator and nothing
with :mod:`pmwvc_analysis.models`.
"""

import dataclasses

import numpy as np
from scipy.linalg import null_space

from pmwvc_core.law.motion import advanced, motion
from support.law_rigs import Port, Users

# Sums of squares, which no signal depends on while nothing limits a force, and ratios.
SUMS = ("energies", "gain", "gains", "slope")


def is_sum(name):
    return name in SUMS or name.endswith("_j")


def floats(state):
    """Return the floats of a law's state in order, sums left out."""
    if isinstance(state, float):
        return [state]
    if not isinstance(state, tuple):
        return []
    names = getattr(state, "_fields", [""] * len(state))
    parts = zip(names, state, strict=True)
    return [x for name, part in parts if not is_sum(name) for x in floats(part)]


def filled(state, values):
    """Return a law's state with other floats, taken from an iterator."""
    if isinstance(state, float):
        return next(values)
    if not isinstance(state, tuple):
        return state
    names = getattr(state, "_fields", [""] * len(state))
    parts = [
        part if is_sum(name) else filled(part, values)
        for name, part in zip(names, state, strict=True)
    ]
    return type(state)(*parts) if hasattr(state, "_fields") else tuple(parts)


class IdentityLoop:
    """Waves, first-order filter, whole frames of delay, and what stands around the port."""

    def __init__(self, scenario):
        self.users, frame_s = scenario.users, scenario.server.period_s
        contacts = [
            dataclasses.replace(user.contact, impedance=float(user.server_impedance))
            for user in self.users
        ]
        self.server = Users(scenario.server, contacts, sides=[user.side for user in self.users])
        for i in range(len(self.users)):
            self.server.join(i, 0.0)
        self.ports = [Port(user.master) for user in self.users]
        self.motions = [
            motion(user.device.mass, user.device.damping, scenario.tick_s) for user in self.users
        ]
        links = [
            [0.0] * round(link.delay_s / frame_s)
            for user in self.users
            for link in (user.link_up, user.link_down)
        ]
        # Of the server, of ports, devices, and waves sent, and what is in the links.
        self.rest = (
            self._of_server(),
            tuple(port.s for port in self.ports),
            tuple((0.0, 0.0, 0.0) for _ in self.users),
            tuple(map(tuple, links)),
        )
        self.size = len(floats(self.rest))

    def _of_server(self):
        e = self.server.s
        avatars = [port.avatar for port in e.ports]
        held = tuple((a.xd, a.f, a.contact.springs[0].deflection) for a in avatars)
        return e.body.x, e.body.xd, held

    def _set_server(self, x, xd, held):
        e, ports = self.server.s, []
        for port, (velocity, force, deflection) in zip(e.ports, held, strict=True):
            [spring] = port.avatar.contact.springs
            springs = (spring._replace(deflection=deflection),)
            contact = port.avatar.contact._replace(springs=springs)
            avatar = port.avatar._replace(xd=velocity, f=force, contact=contact)
            ports.append(port._replace(avatar=avatar))
        self.server.s = e._replace(ports=tuple(ports), body=e.body._replace(x=x, xd=xd))

    def frame(self, state):
        """Return the state a frame later."""
        of_server, of_ports, devices, links = filled(self.rest, iter(state))
        self._set_server(*of_server)
        links = list(map(list, links))
        received = [self._through(links[2 * i], device[2]) for i, device in enumerate(devices)]
        answers, after = self.server.step(received), []
        for i, (port, user) in enumerate(zip(self.ports, self.users, strict=True)):
            port.s, (x, xd, _) = of_ports[i], devices[i]
            port.receive(self._through(links[2 * i + 1], answers[i]))
            for _ in range(user.master.rate_drop):
                f = -port.tick(xd, x=x)
                (x,), (xd,) = advanced((x,), (xd,), (f,), self.motions[i])
            after.append((x, xd, port.send()))
        ports = tuple(port.s for port in self.ports)
        return floats((self._of_server(), ports, tuple(after), tuple(map(tuple, links))))

    @staticmethod
    def _through(link, value):
        """Put a value into a link and return the one that comes out."""
        link.insert(0, value)
        return link.pop()

    def spectral_radius(self):
        """Return the largest length of an eigenvalue, rigid motions taken out."""
        a = np.array([self.frame(unit) for unit in np.eye(self.size).tolist()]).T
        for _ in range(2):  # translations, then what moves on with them uniformly
            still = null_space(a - np.eye(len(a)), rcond=1e-11)
            basis, _ = np.linalg.qr(np.hstack([still, np.eye(len(a))]), mode="reduced")
            k = still.shape[1]
            a = (basis.T @ a @ basis)[k:, k:]
        return np.abs(np.linalg.eigvals(a)).max()
