# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop of App. E written out: device, bank, local model, slow wall, position feedback.

It shares nothing with the core. State-space filters by scipy, and a frame as a matrix by stepping
the identity. The local model's force is K (x + theta T_c xd) + B xd, solved with the wave
(``theta`` 0: forward Euler, 1/2: midpoint, 1: backward Euler), or with the force of the tick
before in the decoding (``late``).
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy import signal

TICK_S = 0.001
M = 20
TABLE_1 = (70.0, 20.0, 40.0, 40.0)  # HP: edge and loss of the pass band, of the stop band
FIRST_ORDER = (3.0, 3.0, 0.3, 20.0)  # of the scenario wall_local_model


def butterworth(kind, pass_hz, pass_db, stop_hz, stop_db):
    """A Butterworth filter that meets the pass edge, in state space."""
    order, _ = signal.buttord(pass_hz, stop_hz, pass_db, stop_db, analog=True)
    edge = 2.0 / TICK_S * math.tan(math.pi * pass_hz * TICK_S)
    ratio = (10.0 ** (0.1 * pass_db) - 1.0) ** (0.5 / order)
    cutoff = edge / ratio if kind == "low" else edge * ratio
    zpk = signal.butter(order, cutoff, btype=kind, analog=True, output="zpk")
    return signal.zpk2ss(*signal.bilinear_zpk(*zpk, 1.0 / TICK_S))


@dataclass
class Loop:
    """What is varied; the rest is App. E. ``high`` None: without the bank."""

    damping: float = 5.0
    high: tuple | None = TABLE_1
    k_p: float = 0.0
    theta: float = 0.5
    late: bool = False
    stiffness: float = 500.0
    b: float = 25.0
    mass: float = 0.1
    damping_hd: float = 1.5

    def maps(self):
        """Return A, B of a frame and C, D of the positions at its ticks."""
        low = butterworth("low", 25.0, 20.0, 50.0, 40.0)
        filters = {"low": low}
        if self.high:
            filters["up"] = butterworth("high", *self.high)
            filters["down"] = butterworth("low", 300.0, 1.0, 600.0, 40.0)
        sizes = {name: len(f[0]) for name, f in filters.items()}
        sizes |= dict.fromkeys(("x", "xd", "y", "e", "x_l", "f_l"), 1)
        count = sum(sizes.values())
        rows = np.eye(count + M)
        ends = np.cumsum(list(sizes.values()))
        s = {n: rows[e - size : e] for (n, size), e in zip(sizes.items(), ends, strict=True)}
        f_h, positions = rows[count:], []
        v = self._wall(s)
        for k in range(M):
            positions.append(s["x"])
            f_m = self._tick(s, filters, v)
            self._device(s, f_h[k] - f_m)
        out = np.vstack([s[name] for name in sizes])
        x = np.vstack(positions)
        return out[:, :count], out[:, count:], x[:, :count], x[:, count:]

    def _wall(self, s):
        """500 N/m and 1 N s/m at 50 Hz, by the midpoint rule; the returning wave."""
        frame_s, ratio = M * TICK_S, math.sqrt(2.0 / self.b)
        slope = 0.5 * 500.0 * frame_s + 1.0
        free = ratio * s["y"]
        f = (500.0 * s["e"] + slope * free) / (1.0 + slope / self.b)
        s["e"] = s["e"] + frame_s * (free - f / self.b)
        return s["y"] - ratio * f

    def _tick(self, s, filters, v):
        root = math.sqrt(2.0 * self.b)
        v = v - self.k_p * (s["x"] - s["e"])
        if self.high:
            own, gain = self._model(s)
            up, down = filters["up"], filters["down"]
            before = own + gain * (up[2] @ s["up"])
            w = v + down[2] @ s["down"] + down[3] * before
            through = float(down[3][0, 0] * gain * up[3][0, 0])
            u = (root * s["xd"] - w) / (1.0 + through)
            v = w + through * u
            self._answer(s, filters, u, own, gain)
        else:
            u = root * s["xd"] - v
        s["y"] = self._filter(s, filters, "low", u)
        return self.b * s["xd"] - root * v

    def _model(self, s):
        """v2 = own + gain u2."""
        ratio = math.sqrt(2.0 / self.b)
        slope = self.stiffness * self.theta * TICK_S + self.damping
        pull = self.stiffness * s["x_l"]
        if self.late:
            return -ratio * (pull - slope * s["f_l"] / self.b), 1.0 - 2.0 * slope / self.b
        share = 1.0 + slope / self.b
        return -ratio * pull / share, 2.0 / share - 1.0

    def _answer(self, s, filters, u, own, gain):
        ratio = math.sqrt(2.0 / self.b)
        u2 = self._filter(s, filters, "up", u)
        v2 = own + gain * u2
        f = (u2 - v2) / ratio
        xd = ratio * u2 - (s["f_l"] if self.late else f) / self.b
        s["x_l"], s["f_l"] = s["x_l"] + TICK_S * xd, f
        self._filter(s, filters, "down", v2)

    def _device(self, s, force):
        p = math.exp(-self.damping_hd * TICK_S / self.mass)
        reach = (1.0 - p) * self.mass / self.damping_hd
        s["x"] = s["x"] + reach * s["xd"] + (TICK_S - reach) / self.damping_hd * force
        s["xd"] = p * s["xd"] + (1.0 - p) / self.damping_hd * force

    @staticmethod
    def _filter(s, filters, name, u):
        a, b, c, d = filters[name]
        y = c @ s[name] + d @ u
        s[name] = a @ s[name] + b @ u
        return y

    def radius(self):
        """Return the largest length of an eigenvalue other than 1.

        Exactly 1 is the device with its wall moved together (nothing tells where the wall is).
        """
        values = np.linalg.eigvals(self.maps()[0])
        return np.abs(values[np.abs(values - 1.0) > 1e-7]).max()

    def admittance(self, frequency_hz):
        """Return x_m/f_h at one frequency, images left out [m/N]."""
        a, b, c, d = self.maps()
        theta = 2.0 * math.pi * np.asarray(frequency_hz) * TICK_S
        found = []
        for angle in np.atleast_1d(theta):
            lifted = c @ np.linalg.solve(np.exp(1j * angle * M) * np.eye(len(a)) - a, b) + d
            turn = np.exp(1j * angle * np.arange(M))
            found.append(turn.conj() @ lifted @ turn / M)
        return np.array(found)

    def first_peak_hz(self):
        """Return the lowest frequency at which |x/f| has a maximum."""
        frequency = np.arange(0.5, 20.0, 0.05)
        size = np.abs(self.admittance(frequency))
        inner = (size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])
        return frequency[1:-1][inner][0]

    def trace(self, forces):
        """Return the positions under forces ``(ticks,)``, from rest."""
        a, b, c, d = self.maps()
        state, found = np.zeros(len(a)), []
        for frame in np.reshape(forces, (-1, M)):
            found.append(c @ state + d @ frame)
            state = a @ state + b @ frame
        return np.concatenate(found)
