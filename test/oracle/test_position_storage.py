# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Position feedback with a declared storage: the offset under a lasting grip goes to zero, and no
more than the storage is ever given out.
"""

import math

import numpy as np
import pytest
from support import plain as files
from support.packer import Packer
from support.port_rig import Port

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.prediction.text import lines
from pmwvc_analysis.traces.apart import apart
from pmwvc_analysis.verdicts.passivity import passivity, verdict
from pmwvc_core.params import MasterParams, PositionParams
from pmwvc_core.params.server import PspmParams
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.wave.filter_design import response
from pmwvc_core.wave.impedance import largest

ENCODER = ("device.encoder_step_m=5.5e-5", "device.velocity=euler")
FIRST_ORDER = "master.filter.kind=first_order"


def carried(*settings, duration_s):
    scenario = files.load("carry_16ms", settings_texts=settings, duration_s=duration_s)
    return simulate_one(scenario), scenario


def apart_m(traces):
    """How much closer than their avatars the two devices are at the end."""
    both = [apart(traces, user) for user in traces.users]
    left, right = (f.error[f.time_s > traces.duration_s - 0.5, 0].mean() for f in both)
    return left - right


@pytest.mark.parametrize(("delay_s", "storage_j"), [(0.016, 5e-3), (0.150, 2e-2)])
def test_with_a_storage_the_offset_goes_to_zero_and_the_storage_is_all_that_is_lent(
    delay_s, storage_j
):
    settings = (
        f"link.delay_s={delay_s}",
        "safety.timeout_s=0.5",
        "master.position.adapts=true",
        f"master.position.storage_j={storage_j}",
    )
    traces, scenario = carried(*settings, duration_s=9.0)
    assert abs(apart_m(traces)) < 5e-5
    for entry in user_energies(traces, scenario):
        assert entry.joint.declared_j == storage_j
        assert -storage_j <= entry.joint.minimum_j < -1e-4  # it took the loan
        assert entry.passive
    found = passivity(traces, scenario, budget(traces, scenario))
    assert found.session is True
    assert f"declared storage {1e3 * storage_j:.3g} mJ" in verdict(found, "user1")
    assert any("declared storage" in line for line in lines(scenario, live=False))
    # the controls: without a storage there is nothing to take, and undeclared it is a violation
    without, _ = carried(*settings[:3], duration_s=5.0)
    assert abs(apart_m(without)) > 2e-3
    assert not any(entry.passive for entry in user_energies(traces))


def test_the_storage_is_the_most_that_is_ever_spent():
    """A hand swings with the avatar kept away: all is asked for, the storage is given."""
    for storage_j in (0.0, 1e-3, 2e-2):
        params = MasterParams(position=PositionParams(gain=100.0, storage_j=storage_j))
        port, server = Port(params), Packer(7, period=params.frame_s)
        x, hand, sent = 0.0, 0.0, 0.0
        least = 0.0
        for frame in range(400):
            sent += port.send() ** 2 * params.frame_s / 2
            packet = server.pack(0.0, -0.05 * (frame > 0), 0, echo=(frame + 1, 0, 0))
            port.on_packet(packet)
            port.receive(packet.wave)
            for tick in range(params.rate_drop):
                xd = 0.05 * math.sin(0.02 * (8 * frame + tick))
                f = port.step(x, xd)
                port.applied(f)
                hand += f * xd * params.tick_s
                x += xd * params.tick_s
                least = min(least, hand - sent)
        assert least >= -storage_j - 1e-12
        assert least <= -0.5 * storage_j


def round_trip_s(delay_frames, **values):
    """The round trip behind an adapted gain, from the force that an offset of 1 mm makes."""
    position = PositionParams(adapts=True, storage_j=1.0, most_j=10.0)
    params = MasterParams(position=position, **values)
    port, server = Port(params), Packer(7, period=params.frame_s)
    for frame in range(1, 800):
        port.send()
        echo = (max(frame - delay_frames, 1), 0, 0)
        port.on_packet(server.pack(0.0, -1e-3 * (frame > 1), 0, echo=echo))
        port.receive(0.0)
        for _ in range(params.rate_drop):
            f = port.step(0.0, 0.0)
            port.applied(f)
    return params.impedance * 1e-3 / f  # F = b e/tau


@pytest.mark.parametrize(("delay_frames", "b"), [(2, 25.0), (10, 5.0), (40, 25.0)])
def test_an_adapted_gain_follows_the_round_trip(delay_frames, b):
    found = round_trip_s(delay_frames, impedance=b)
    frame_s = MasterParams().frame_s
    assert found == pytest.approx(delay_frames * frame_s + 0.0115, abs=0.01)
    more = round_trip_s(delay_frames + 5, impedance=b)
    assert more - found == pytest.approx(5 * frame_s, rel=1e-3)


def test_behind_an_encoder_nothing_is_spent_that_the_hand_did_not_give():
    """Booked by the velocity measured, the noise would pay for everything: -5.6 mJ in a minute."""
    settings = (*ENCODER, FIRST_ORDER, "safety.max_slew=20000")
    traces, scenario = carried(*settings, "master.position.gain=80", duration_s=10.0)
    plain, _ = carried(*settings, duration_s=10.0)
    for found, without, user in zip(
        user_energies(traces, scenario), user_energies(plain, scenario), traces.users, strict=True
    ):
        assert found.joint.minimum_j > without.joint.minimum_j - 2e-4
        assert user.accounts["position_discarded"][-1] > 0.06  # what the noise would have paid
        assert user.accounts["position_spent"][-1] < 1e-6
    # the control: with exact sensors the same hand does pay
    exact, _ = carried(FIRST_ORDER, "master.position.gain=80", duration_s=4.0)
    assert all(user.accounts["position_spent"][-1] > 1e-5 for user in exact.users)


def encoder_noise_w(user):
    """Power of an encoder's noise in the packets: where a grip chatters over several counts the
    rounding error is evenly spread over a step. Equation: docs/theory.md 14.4.
    """
    device, master, turn = user.device, user.master, np.arange(16384) / 16384
    options = {"tick_s": master.tick_s, "rate_drop": master.rate_drop}
    passed = response(master.filter, turn / master.tick_s, **options)
    differenced = np.mean(np.abs(2.0 * np.sin(np.pi * turn) * passed) ** 2)
    variance = device.encoder_step_m**2 / 12.0 / master.tick_s**2
    return float(largest(user.in_contact.impedance) * variance * differenced)


def test_the_noise_of_an_encoder_is_what_the_formula_gives():
    filtering = "master.filter.kind=integrate_and_dump"
    traces, scenario = carried(*ENCODER, filtering, "safety.max_slew=20000", duration_s=9.0)
    said = encoder_noise_w(scenario.users[0])
    clean, _ = carried(filtering, duration_s=9.0)
    for noisy, quiet in zip(user_energies(traces), user_energies(clean), strict=True):
        rows = noisy.joint.time_s > 6.0
        lost = quiet.joint.balance_j[rows] - noisy.joint.balance_j[rows]
        slope = np.polyfit(noisy.joint.time_s[rows], lost, 1)[0]
        assert slope == pytest.approx(said, rel=0.3)
    lag = files.load("carry_16ms", settings_texts=[*ENCODER, FIRST_ORDER])
    assert 0.0 < encoder_noise_w(lag.users[0]) < 0.1 * said  # its lag keeps the noise back


def test_a_tank_that_begins_full_is_a_declared_storage():
    traces, scenario = carried("controller=pspm", duration_s=1.0)
    for entry in user_energies(traces, scenario):
        assert entry.joint.declared_j == pytest.approx(2 * PspmParams().initial_j)
