# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Transmitted admittance of App. A Fig. 4 and App. E, by the model and by a second route.

The second route steps unit states of device, filter and wall through one frame by itself. It knows
two orders of a frame: the packet carries the filter's output of the last tick (ours), or that of
the very tick at which its answer is applied, with the loop through filter and wall solved. The
known numbers of Fig. 4 are those of the second order: a lag of one tick less.
"""

import numpy as np
import pytest
from scipy import linalg

from pmwvc_analysis.models import linearize
from pmwvc_analysis.transparency import frequency
from pmwvc_analysis.transparency.transparency import transparency
from pmwvc_core.params import FilterParams
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.wave.filter_design import design

TICK_S, M = 1e-3, 20
BUTTERWORTH = FilterParams(kind="butterworth", pass_hz=25.0, stop_hz=50.0)


def printed(*, impedance, mass=0.15, damping=1.0, stiffness=3500.0, contact_damping=25.0):
    return parse_scenario(
        {
            "name": "printed",
            "duration_s": 5.0,
            "controller": "pmwvc",
            "channel": "plain",
            "users": 1,
            "master": {
                "impedance": impedance,
                "rate_drop": M,
                "hold": "zoh",
                "filter": {"kind": "butterworth", "pass_hz": 25.0, "stop_hz": 50.0},
            },
            "device": {"mass": mass, "damping": damping},
            "operator": {"kind": "chirp"},
            "server": {
                "environment": "wall",
                "contact": "bilateral",
                "coupling": "unwrapped",
                "integrator": "trapezoid",
                "period_s": M * TICK_S,
                "contact_stiffness": stiffness,
                "contact_damping": contact_damping,
            },
            "task": {"kind": "free"},
        }
    )


class SecondRoute:
    """A frame in matrices of its own: x, xd, filter (4), place and velocity at the wall, u_lp."""

    def __init__(self, scenario, *, same_tick):
        user = scenario.users[0]
        self.b, self.same_tick = user.master.impedance, same_tick
        self.K, self.B = user.contact.contact_stiffness, user.contact.contact_damping
        m, d = user.device.mass, user.device.damping
        big = np.zeros((3, 3))
        big[0, 1], big[1, 1], big[1, 2] = 1.0, -d / m, 1.0 / m
        self.device = linalg.expm(big * TICK_S)[:2]
        self.filter = filter_matrices()
        self.frame = self._lift()

    def _lift(self):
        size = 9 + M
        unit = np.eye(size)
        state, outputs = unit[:9].copy(), []
        x, xd = state[0], state[1]
        z, place, rate, last = state[2:6], state[6], state[7], state[8]
        A, B, C, D = self.filter
        gain = np.sqrt(2 * self.b)
        h = M * TICK_S
        total = self.b + self.B + self.K * h / 2
        # the wall: xd_s = (gain u - K (place + h rate/2))/total, v = u - sqrt(2/b) F
        pull = -self.K * (place + 0.5 * h * rate) / total
        slope = gain / total
        if (
            self.same_tick
        ):  # u = C z + D (gain xd - v), v = u - sqrt(2/b) F(u), F = b(ratio u - xd_s)
            passes = -1.0 + np.sqrt(2 * self.b) * slope  # v = passes u + gain pull
            u = (C @ z + D * (gain * xd - gain * pull)) / (1.0 + D * passes)
        else:
            u = last
        rate_new = slope * u + pull
        v = gain * rate_new - u
        place = place + 0.5 * h * (rate + rate_new)
        for tick in range(M):
            outputs.append(x)
            wave = gain * xd - v
            force = unit[9 + tick] - (self.b * xd - gain * v)
            last = C @ z + D * wave
            z = A @ z + np.outer(B, wave)
            x, xd = self.device @ np.stack([x, xd, force])
        return np.vstack([x, xd, z, place, rate_new, last]), np.stack(outputs)

    def response(self, hertz):
        step, out = self.frame
        angle = 2 * np.pi * hertz * TICK_S
        wave = np.exp(1j * angle * np.arange(M))
        state = np.linalg.solve(
            np.exp(1j * angle * M) * np.eye(9) - step[:, :9], step[:, 9:] @ wave
        )
        return np.mean((out[:, :9] @ state + out[:, 9:] @ wave) * wave.conj())

    def peak_hz(self):
        grid = np.arange(0.5, 40.0, 0.005)
        size = np.abs([self.response(f) for f in grid])
        return grid[1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:]))[0]]


def filter_matrices():
    """The cascade as one state space, by the impulse responses of its sections in series."""
    A, B, C, D = np.zeros((0, 0)), np.zeros(0), np.zeros(0), 1.0
    for b0, b1, b2, _, a1, a2 in design(BUTTERWORTH, tick_s=TICK_S):
        a = np.array([[-a1, 1.0], [-a2, 0.0]])
        b = np.array([b1 - a1 * b0, b2 - a2 * b0])
        c, d = np.array([1.0, 0.0]), b0
        A = np.block([[A, np.zeros((len(A), 2))], [np.outer(b, C), a]])
        B, C, D = np.concatenate([B, b * D]), np.concatenate([d * C, c]), d * D
    return A, B, C, D


@pytest.mark.parametrize("impedance", [25.0, 80.0])
def test_the_model_agrees_with_the_second_route(impedance):
    scenario = printed(impedance=impedance)
    route, model = SecondRoute(scenario, same_tick=False), linearize.build(scenario)
    hertz = np.array([0.5, 3.0, 7.4, 24.0, 60.0, 310.0])
    np.testing.assert_allclose(
        frequency.response(model, hertz), [route.response(f) for f in hertz], rtol=1e-8
    )


@pytest.mark.parametrize(
    ("impedance", "stiffness", "peak_hz"), [(25.0, 939.4, 7.47), (80.0, 1889.2, 5.97)]
)
def test_fig_4_of_appendix_a(impedance, stiffness, peak_hz):
    scenario = printed(impedance=impedance)
    known = SecondRoute(scenario, same_tick=True)
    assert 1 / known.response(0.01).real == pytest.approx(stiffness, rel=5e-4)
    assert known.peak_hz() == pytest.approx(peak_hz, abs=0.015)
    # ours sends the output of the last tick: a tick more of lag, b/(2 T_c) in series
    felt = transparency(scenario, np.array([1.0])).rendered
    assert 1 / felt.k_felt - TICK_S / (2 * impedance) == pytest.approx(1 / stiffness, rel=5e-4)
    assert felt.first_peak_hz == pytest.approx(peak_hz, rel=0.015)
    assert felt.first_peak_hz < peak_hz


def test_the_ideal_of_appendix_a():
    ideal = transparency(printed(impedance=25.0), np.array([1.0])).ideal
    assert ideal.k_felt == pytest.approx(3500.0, rel=1e-4)
    assert ideal.first_peak_hz == pytest.approx(15.87, abs=0.02)


def test_the_wall_of_appendix_e():
    scenario = printed(impedance=25.0, mass=0.1, damping=1.5, stiffness=500.0, contact_damping=1.0)
    found = transparency(scenario, np.array([1.0]))
    assert found.ideal.first_peak_hz == pytest.approx(11.0, abs=0.05)
    assert found.ideal.k_felt == pytest.approx(500.0, rel=1e-4)
    assert found.rendered.k_felt == pytest.approx(357.0, rel=2e-3)
