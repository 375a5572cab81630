# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A small closed loop around the server's law, written out by hand, for printed numbers.

Two undamped devices, first-order filter, rate drop, hold and whole-frame delays are a dozen lines
here and share nothing with the core; only the server is the real one. Order of events in a frame:
send the filter's output of the last tick, serve the packet sent ``delay`` frames ago, take the
answer sent ``delay`` frames ago, M ticks.

A loop's state is an array ``(runs, states)``. Stepping the identity through one frame gives the
monodromy matrix.
"""

from dataclasses import dataclass

import numpy as np

from pmwvc_core.params import ContactParams, ServerParams
from support.law_rigs import Users

TICK_S = 0.001
M = 8
FRAME_S = M * TICK_S
IMPEDANCE = 25.0
DEVICE_MASS = 0.25


@dataclass
class Scheme:
    """What is varied; the rest is the example of App. B."""

    coupling: str = "implicit"
    integrator: str = "backward_euler"
    hold: str = "zoh"
    pole_rad_s: float = 50.0
    delay: int = 0
    direct: bool = False


class Layout:
    """Names for slices of the state, in the order asked for."""

    def __init__(self):
        self.size = 0
        self.parts = {}

    def add(self, name, width=2):
        self.parts[name] = slice(self.size, self.size + width)
        self.size += width

    def split(self, state):
        return {name: state[:, part].copy() for name, part in self.parts.items()}

    def join(self, values):
        return np.concatenate([values[name] for name in self.parts], axis=1)


class Loop:
    """Two users, one cube, stiffness ``k`` and damping 10 N s/m in both contacts."""

    def __init__(self, scheme, k, *, wrap=None, hand=(0.0, 0.0)):
        self.scheme = scheme
        self.hand = np.array(hand)
        contact = ContactParams(contact="bilateral", contact_stiffness=k, contact_damping=10.0)
        self.server = Users(
            ServerParams(coupling=scheme.coupling, integrator=scheme.integrator, period_s=FRAME_S),
            [contact] * 2,
            controller="direct" if scheme.direct else "pmwvc",
            b=IMPEDANCE,
        )
        self.wrap = wrap
        for i in (0, 1):
            self.server.join(i, 0.0)
        self.layout = Layout()
        for name in ("x", "xd", "e", "xd_s", "f_s"):
            self.layout.add(name)
        self.layout.add("x_o", 1)
        self.layout.add("xd_o", 1)
        if not scheme.direct:
            self.layout.add("y")
            self.layout.add("v")
        for age in range(1, scheme.delay + 1):
            self.layout.add(f"up{age}")
            self.layout.add(f"down{age}")
            if scheme.direct:
                self.layout.add(f"up{age}d")

    def frame(self, state):
        """Return the states one frame later."""
        s = self.layout.split(state)
        delay, direct = self.scheme.delay, self.scheme.direct
        up, upd, down = [s["x"] if direct else s["y"]], [s["xd"]], []
        up += [s[f"up{age}"] for age in range(1, delay + 1)]
        if direct:
            upd += [s[f"up{age}d"] for age in range(1, delay + 1)]
            received = np.stack([up[-1], upd[-1]], axis=-1)
        else:
            received = up[-1]
        down = [self._serve(s, received.tolist())]
        down += [s[f"down{age}"] for age in range(1, delay + 1)]
        self._ticks(s, down[-1])
        for age in range(1, delay + 1):
            s[f"up{age}"], s[f"down{age}"] = up[age - 1], down[age - 1]
            if direct:
                s[f"up{age}d"] = upd[age - 1]
        return self.layout.join(s)

    def _ticks(self, s, answer):
        b, p = IMPEDANCE, np.exp(-self.scheme.pole_rad_s * TICK_S)
        for j in range(1, M + 1):
            if self.scheme.direct:
                force = answer
            else:
                v_m = answer
                if self.scheme.hold == "foh":
                    v_m = s["v"] + (answer - s["v"]) * j / M
                force = b * s["xd"] - np.sqrt(2 * b) * v_m
                s["y"] = p * s["y"] + (1 - p) * (np.sqrt(2 * b) * s["xd"] - v_m)
            acceleration = (self.hand - force) / DEVICE_MASS
            s["x"] = s["x"] + TICK_S * s["xd"] + TICK_S**2 / 2 * acceleration
            s["xd"] = s["xd"] + TICK_S * acceleration
        if not self.scheme.direct:
            s["v"] = answer

    def _serve(self, s, received):
        """Step the server for each run from its own state; return what it answers."""
        server, answers, before = self.server, [], self.server.s
        for run, came in enumerate(received):
            ports = []
            for i, port in enumerate(before.ports):
                [spring] = port.avatar.contact.springs
                springs = (spring._replace(deflection=float(s["e"][run, i])),)
                contact = port.avatar.contact._replace(springs=springs)
                signals = {"xd": (float(s["xd_s"][run, i]),), "f": (float(s["f_s"][run, i]),)}
                avatar = port.avatar._replace(contact=contact, **signals)
                ports.append(port._replace(avatar=avatar))
            x, xd = float(s["x_o"][run, 0]), float(s["xd_o"][run, 0])
            body = before.body._replace(x=(x,), xd=(xd,))
            server.s = before._replace(ports=tuple(ports), body=body)
            answers.append(server.step([tuple(w) if self.scheme.direct else w for w in came]))
            if self.wrap is not None:
                self.wrap(server)
            s["x_o"][run], s["xd_o"][run] = server.x_o, server.xd_o
            s["xd_s"][run], s["f_s"][run] = server.xd_s, server.f_s
            for i, port in enumerate(server.s.ports):
                s["e"][run, i] = port.avatar.contact.springs[0].deflection
        server.s = before
        return np.array(answers)

    def monodromy(self):
        """Return A with state(n+1) = A state(n) (columns)."""
        return self.frame(np.eye(self.layout.size)).T

    def rigid_motions(self):
        """Return the columns of what moves without force, which is no instability.

        With waves a device's position acts on nothing, so each one and the object's is a
        translation of its own; with direct coupling all move together. Then uniform motion, with
        waves of sqrt(b/2) times the velocity.
        """
        direct, delay = self.scheme.direct, self.scheme.delay
        runs = 1 if direct else 3
        moved = self.layout.split(np.zeros((runs + 1, self.layout.size)))
        if direct:
            for name in ("x", "x_o", *(f"up{age}" for age in range(1, delay + 1))):
                moved[name][0] = 1.0
            for age in range(1, delay + 1):
                moved[f"up{age}"][1] = -age * FRAME_S
                moved[f"up{age}d"][1] = 1.0
            moved["x_o"][1] = -(delay + 1) * FRAME_S  # as of the last step
        else:
            moved["x"][0, 0] = moved["x"][1, 1] = moved["x_o"][2] = 1.0
            for name in ("y", "v", *(k for k in self.layout.parts if k.startswith(("up", "do")))):
                moved[name][runs] = np.sqrt(IMPEDANCE / 2.0)
        for name in ("xd", "xd_s", "xd_o"):
            moved[name][runs] = 1.0
        return self.layout.join(moved).T

    def spectral_radius(self):
        """Return the largest |eigenvalue| of a frame on the quotient by rigid motions."""
        a, rigid = self.monodromy(), self.rigid_motions()
        still, drifting = rigid[:, :-1], rigid[:, -1:]
        scale = np.abs(a).max()
        np.testing.assert_allclose(a @ still, still, atol=1e-12 * scale)
        change = a @ drifting - drifting
        rest = change - still @ np.linalg.lstsq(still, change, rcond=None)[0]
        np.testing.assert_allclose(rest, 0.0, atol=1e-12 * scale)
        basis, _ = np.linalg.qr(rigid, mode="complete")
        k = rigid.shape[1]
        return np.abs(np.linalg.eigvals((basis.T @ a @ basis)[k:, k:])).max()


def is_stable(scheme, k, **loop):
    """Tell whether two users with contacts of ``k`` N/m are stable."""
    return Loop(scheme, k, **loop).spectral_radius() <= 1.0 + 1e-9


def k_max(scheme, *, lowest=10.0, highest=3e4, **loop):
    """Return the smallest stiffness at which stability is lost, to 1e-4."""
    grid = np.geomspace(lowest, highest, 60)
    low = 0.0
    for high in grid:
        if not is_stable(scheme, high, **loop):
            break
        low = high
    else:
        return np.inf
    while high - low > 1e-4 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_stable(scheme, middle, **loop) else (low, middle)
    return low
