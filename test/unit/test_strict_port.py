# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of the strict channel: packets are paid by what channel and hand gave."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import Port

from pmwvc_core.law.channel.playout import waiting
from pmwvc_core.law.port.strict_master import LIMIT_J, MORE, MUCH_J
from pmwvc_core.params import FilterParams, MasterParams

M, TICK_S, B = 8, 0.001, 25.0
ROOT = np.sqrt(2.0 * B)


def made():
    """Return a port at rest."""
    return Port(MasterParams(impedance=B, rate_drop=M), channel="strict")


def came_j(port):
    """Return what the channel gave to a port [J]."""
    moved = port.playout.moved
    return moved.given_j + moved.released_j


def ends(seed, *, limited=1.0, count_m=0.0, ticks=400):
    """Drive a port with any motion and any returning wave; yield it at each packet, with the work
    of the force applied, the integrals of both waves, and the position measured.
    """
    rng = np.random.default_rng(seed)
    port = made()
    x = work = up = down = xd = last = 0.0

    def read():
        return float(np.floor(x / count_m) * count_m) if count_m else x

    for k in range(ticks):
        before = read()
        if before != last and abs(xd * TICK_S - (before - last)) < 1e-8 and count_m:
            return  # one such tick in a million looks like a velocity that is the jump of counts
        last = before
        if k % M == 0:
            port.measure(read(), xd)
            up += port.send() * M * TICK_S
            yield port, work, up + down, read()
            wave = float(rng.normal())
            port.come(wave * M * TICK_S, 0.5 * wave**2 * M * TICK_S, M * TICK_S)
        f = limited * port.step(before, xd) + (1.0 - limited) * float(rng.normal())
        port.applied(f)
        down += port.v_m * TICK_S
        xd = 0.9 * (xd + 0.2 * float(rng.normal()))
        x = x + (xd * TICK_S if k else 1e-9)  # a step as small as that tells that x is exact
        work += f * (read() - before)


@settings(max_examples=30)
@given(
    seed=st.integers(0, 2**32 - 1),
    limited=st.sampled_from((0.0, 0.5, 1.0)),
    count_m=st.sampled_from((0.0, 55e-6)),
)
def test_energy_sent_is_what_channel_and_hand_gave(seed, limited, count_m):
    before = 0.0
    for port, work, _, _ in ends(seed, limited=limited, count_m=count_m):
        sent_j, node_j = port.sent.energy_j, port.s.node_j
        assert sent_j + node_j == pytest.approx(came_j(port) + work, rel=1e-9, abs=1e-12)
        assert sent_j >= before
        assert sent_j == before or node_j >= -1e-15  # nothing is paid that is not there
        before = sent_j


def test_displacement_is_that_of_the_device():
    """U + V = sqrt(2b) x, whatever velocity was measured and whatever force was let through."""
    for _, _, integral, x in ends(5, limited=0.5):
        assert integral == pytest.approx(ROOT * x, rel=1e-9, abs=1e-12)


def test_displacement_behind_an_encoder_is_within_one_count():
    off = [abs(integral / ROOT - x) for *_, integral, x in ends(6, count_m=55e-6)]
    assert max(off) <= 55e-6 * (1.0 + 1e-9)
    assert max(off) > 0.0  # it is smoothed


def test_the_plain_port_loses_displacement():
    """The control: the wave of the velocity measured, behind the filter of the plain channel."""
    rng, x, xd, integral = np.random.default_rng(5), 0.0, 0.0, 0.0
    filtering = FilterParams(kind="first_order", pole_rad_s=50.0)
    port = Port(MasterParams(impedance=B, rate_drop=M, filter=filtering))
    for k in range(400):
        if k % M == 0:
            integral += port.send() * M * TICK_S
        port.applied(port.step(x, xd))
        integral += port.v_m * TICK_S
        xd = 0.9 * (xd + 0.2 * float(rng.normal()))
        x += xd * TICK_S
    assert abs(integral - ROOT * x) > 1e-3 * ROOT


def test_a_node_with_a_deficit_lets_the_returning_wave_wait():
    port = made()
    port.come(0.1 * 0.1, 0.5 * 0.1**2 * 0.1, 0.1)
    x = 0.0
    for _ in range(20):  # a force that pushes along with the motion, which no wave pays for
        port.step(x, 0.5)
        port.applied(-2.0)
        x += 0.5 * TICK_S
    assert port.s.node_j < -LIMIT_J
    assert port.v_m == 0.0
    assert waiting(port.playout)[0] > 0.0  # and is not lost
    assert came_j(port) <= port.playout.moved.received_j


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0, 5.0])
def test_deficit_of_packets_is_rendered_as_damping_and_no_force_at_rest(share):
    port = made()
    port.step(0.0, 0.0)
    port.applied(0.0)
    port.s = port.s._replace(deficit_j=share * MUCH_J)
    for _ in range(500):  # it comes within MEND_S
        port.step(1e-9, 0.02)
        port.applied(0.0)
    assert port.step(1e-9, 0.02) == pytest.approx((1.0 + min(share, 1.0) * MORE) * B * 0.02)
    port.applied(0.0)
    assert port.step(1e-9, 0.0) == 0.0


def test_what_packets_lacked_behind_an_encoder_is_paid_with_the_next_ones():
    """The force is held back for two frames; what is needed twice is there within a second."""
    port = made()
    read = before = wave_j = 0.0
    deficit_j = []
    for k in range(125 * M):
        if k % M == 0:
            port.measure(read, (read - before) / TICK_S)
            wave_j += port.send() ** 2 * M * TICK_S / 2.0
            deficit_j.append(port.s.deficit_j)
        f = port.step(read, (read - before) / TICK_S)
        port.applied(0.0 if 10 * M <= k < 12 * M else f)
        before, read = read, float(np.floor(0.05 * (k + 1) * TICK_S / 55e-6) * 55e-6)
    assert max(deficit_j) > 5e-4
    assert deficit_j[-1] < 0.2 * max(deficit_j)
    assert port.sent.energy_j >= wave_j
