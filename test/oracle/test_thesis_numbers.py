# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Largest stable stiffness of two users on one cube (App. B, Figs. 2 and 3), for each coupling.

The numbers were computed elsewhere from exact multirate matrices; the figures of the dissertation
show the same regions for ``one_frame_late`` when its cut-off is read as the pole in rad/s.
"""

import numpy as np
import pytest
from support.closed_loop import FRAME_S, IMPEDANCE, Loop, Scheme, is_stable, k_max

from pmwvc_core.law.wave.wave import wave_velocity

DELAYS = (0, 1, 2, 3)
LATE = {
    ("zoh", 50): (5280.5, 2470.8, 2166.0, 2224.2),
    ("zoh", 100): (1037.4, 988.2, 965.4, 952.2),
    ("foh", 50): (4528.2, 2433.9, 2164.5, 2181.7),
    ("foh", 100): (973.2, 943.0, 928.3, 919.8),
}
DELAYED = {
    "forward_euler": (2950.1, 3084.7, 2604.5, 2674.5),
    "backward_euler": (8482.3, 3595.2, 2774.5, 2488.5),
}
DIRECT = (2500.0, 335.3, 47.1)


@pytest.mark.parametrize("delay", DELAYS)
@pytest.mark.parametrize(("hold", "pole"), LATE)
def test_largest_stiffness_one_frame_late(hold, pole, delay):
    scheme = Scheme("one_frame_late", hold=hold, pole_rad_s=pole, delay=delay)
    assert k_max(scheme) == pytest.approx(LATE[hold, pole][delay], rel=5e-3)


@pytest.mark.parametrize("delay", DELAYS)
@pytest.mark.parametrize("integrator", DELAYED)
def test_largest_stiffness_with_one_step_delay(integrator, delay):
    scheme = Scheme("one_step_delay", integrator=integrator, delay=delay)
    assert k_max(scheme) == pytest.approx(DELAYED[integrator][delay], rel=5e-3)


@pytest.mark.parametrize("delay", range(len(DIRECT)))
def test_largest_stiffness_of_direct_coupling(delay):
    assert k_max(Scheme(direct=True, delay=delay)) == pytest.approx(DIRECT[delay], rel=5e-3)


def test_direct_coupling_over_three_frames_bears_no_stiffness():
    assert not any(is_stable(Scheme(direct=True, delay=3), k) for k in (0.0, 1e-3, 1.0, 100.0))


@pytest.mark.parametrize("delay", (*DELAYS, 50))
@pytest.mark.parametrize(("hold", "pole"), LATE)
def test_implicit_coupling_knows_no_largest_stiffness(hold, pole, delay):
    scheme = Scheme("implicit", hold=hold, pole_rad_s=pole, delay=delay)
    assert all(is_stable(scheme, k) for k in np.geomspace(1.0, 1e7, 15))


@pytest.mark.parametrize(("delay", "expected"), [(0, 4850), (1, 2854), (2, 2810), (3, 3093)])
def test_reading_the_cut_off_as_20_db_at_50_hz_moves_the_limits(delay, expected):
    scheme = Scheme("one_frame_late", pole_rad_s=2 * np.pi * 50 / np.sqrt(99), delay=delay)
    assert k_max(scheme) == pytest.approx(expected, rel=5e-3)


def test_reading_the_cut_off_as_3_db_at_50_hz_leaves_nothing_stable():
    scheme = Scheme("one_frame_late", pole_rad_s=2 * np.pi * 50)
    assert not any(is_stable(scheme, k) for k in np.geomspace(1e-3, 1e5, 20))


def _as_printed(server):
    """App. B, Eq. 14 with the sign it has in print: a control that must miss the figure."""
    ports = []
    for port in server.s.ports:
        a = port.avatar
        xd = wave_velocity(a.impedance, a.u, (-a.f[0],))
        ports.append(port._replace(avatar=a._replace(xd=xd)))
    server.s = server.s._replace(ports=tuple(ports))


@pytest.mark.parametrize(("delay", "expected"), [(0, 139), (1, 103), (2, 83), (3, 70)])
def test_equation_14_as_published_is_far_from_its_own_figure(delay, expected):
    scheme = Scheme("one_frame_late", delay=delay)
    assert k_max(scheme, wrap=_as_printed) == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize(("delay", "ahead_mm"), [(0, 0.55), (2, 1.19), (3, 1.51)])
def test_pressed_with_one_newton_the_device_stands_ahead_by_the_travel_time(delay, ahead_mm):
    """App. B, Fig. 5: F tau/(2 b) ahead of its avatar, which presses 1 N / K in."""
    scheme = Scheme("one_frame_late", hold="foh", pole_rad_s=50.0, delay=delay)
    loop = Loop(scheme, 500.0, hand=(1.0, -1.0))
    state = np.zeros((1, loop.layout.size))
    for _ in range(round(12.0 / FRAME_S)):
        state = loop.frame(state)
    s = loop.layout.split(state)
    np.testing.assert_allclose(s["f_s"], [[1.0, -1.0]], rtol=1e-6)
    np.testing.assert_allclose(s["e"], [[2e-3, -2e-3]], rtol=1e-6)
    ahead = s["x"] - (s["x_o"] + s["e"])
    np.testing.assert_allclose(ahead * 1e3, [[ahead_mm, -ahead_mm]], rtol=5e-3)
    travel_s = 2 * IMPEDANCE * ahead[0, 0]
    assert travel_s == pytest.approx(0.0275 + 2 * delay * FRAME_S, rel=5e-3)
