# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The ramp of a playout and the impedance that follows contact: no energy beyond what came and was
lent, no displacement lost, whatever the courses of impedance, steps and network; and what a hand
feels of them.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmwvc_analysis.compare.probes import free_space, pressed_stiffness
from pmwvc_bringup import scenarios as files
from pmwvc_core.law.channel.playout import (
    Energies,
    PlayoutParams,
    add,
    play,
    ramped,
    resting_playout,
    waiting,
)
from pmwvc_core.law.wave.following import FREE, followed
from pmwvc_core.plant.hand import RecordedHand, recorded_motion
from pmwvc_core.simulation.conditions import Conditions, place_of
from pmwvc_core.simulation.session import simulate_one

H, E0 = 0.001, 2e-3
ROUNDING = 1e-12
FOLLOWS = ("master.impedance=8", "master.contact_impedance=90")
LOAN = ("master.position.adapts=true", "master.position.storage_j=0.02")


def played(seed, *, counts_r=True, ticks=3000):
    """Play random segments late, lost and underpaid, with random courses of r and N; return the
    least of received + E0 - given, and the largest displacement that is nowhere.
    """
    rng, p = np.random.default_rng(seed), PlayoutParams(0.5, 0.1, E0, -1e-3)
    s, came, given, out, least, lost = resting_playout((0.0,), Energies()), 0.0, 0.0, 0.0, 0.0, 0.0
    moved, wave, due, r, most = 0.0, 0.0, 5, 1.0, float(rng.uniform(1.0, 12.0))
    for tick in range(ticks):
        while tick >= due:
            lasts_s = 0.008 * int(rng.integers(1, 4))
            wave += 0.2 * float(rng.normal()) - 0.1 * wave
            paid = float(rng.choice([0.3, 1.0, 1.0, 2.0])) * 0.5 * wave**2 * lasts_s
            s = add(s, (wave * lasts_s,), paid, lasts_s, E0)
            moved, came = moved + wave * lasts_s, came + paid
            due += round(1e3 * lasts_s) + int(rng.integers(0, 30)) * int(rng.random() < 0.2)
        r = min(max(r + 0.1 * float(rng.normal()) * most, 1.0), most)
        if rng.random() < 0.01:
            s = ramped(s, int(rng.integers(1, 12)))
        s, (w,) = play(s._replace(raised=r if counts_r else 1.0), H, p)
        given, out = given + 0.5 * r * w * w * H, out + w * H
        least = min(least, came + E0 - given)
        lost = max(lost, abs(moved - out - waiting(s)[0]))
    return least, lost


@settings(max_examples=12)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_course_of_impedance_or_ramp_gives_out_more_or_loses_displacement(seed):
    least, lost = played(seed)
    assert least >= -ROUNDING
    assert lost < 1e-11


def test_waves_that_are_paid_for_as_if_the_impedance_stayed_give_out_more():
    """The control."""
    assert min(played(seed, counts_r=False)[0] for seed in range(5)) < -1e-3


def test_the_impedance_rises_in_a_contact_and_falls_behind_it():
    """r from 1 to n in 0.1 s, from the first contact force above 0.05 N; 60 ms behind the last
    one it falls, in 50 ms. Packets carry whole levels of it. docs/theory.md 17.28
    """
    s, found = FREE, []
    for k in range(500):
        force = (0.06,) if 50 <= k < 250 else (0.04,)
        s = followed(s, force, H, 4.0)
        found.append(s.ratio)
    times_s = np.array([0.0, 0.049, 0.149, 0.308, 0.358, 0.499])
    expected = np.interp(H * np.arange(500), times_s, [1.0, 1.0, 4.0, 4.0, 1.0, 1.0])
    np.testing.assert_allclose(found, expected, atol=3.0 / 255.0 + 1e-9)
    assert found[148] < found[149] == found[308] == 4.0 and found[358] == 1.0
    assert followed(FREE, (1.0,), H, 1.0) == FREE  # of a constant impedance


def wall(delay_s, *texts):
    base = (
        "server.contact_stiffness=2000",
        "server.contact_damping=10",
        f"link.delay_s={delay_s}",
    )
    return files.load("wall", settings_texts=(*base, *texts), duration_s=8.0)


def test_a_wall_is_stiffer_and_free_motion_lighter_than_any_constant_impedance_renders():
    """More than twice what any linear link of this round trip has, K/M <= 4/tau^2."""
    delay_s = 0.024
    scenario = wall(delay_s, *FOLLOWS)
    mass = free_space(scenario).mass_kg - scenario.users[0].device.mass
    stiffness = pressed_stiffness(scenario)
    assert stiffness >= 1150.0 and mass <= 0.25
    link = 1.0 / (1.0 / stiffness - 1.0 / 2000.0)
    assert link / mass > 2.0 * 4.0 / (2.0 * delay_s) ** 2


def test_with_a_loan_the_wall_itself_is_felt():
    """The control: a constant impedance is softer."""
    assert pressed_stiffness(wall(0.024, *FOLLOWS, *LOAN)) >= 1950.0
    assert pressed_stiffness(wall(0.024, "master.impedance=25")) < 1150.0


@pytest.mark.parametrize(
    "network", [(), ("link.loss=0.1", "link.jitter=uniform", "link.jitter_s=0.008")]
)
def test_a_press_moves_nothing_and_costs_the_hand_no_more_than_was_lent(network):
    scenario = wall(0.016, *FOLLOWS, *network, "task.kind=free", "operator.grip_stiffness=375")
    (user,) = scenario.users
    at, turns = place_of(user, scenario), np.linspace(0.0, 2.0 * np.pi, 1000)
    press = 0.5 * 0.009 * (1.0 - np.cos(turns))  # 5 mm to the wall, 1.5 N there
    path = np.concatenate([np.tile(press, 4), np.zeros(4000)])[:, np.newaxis]
    hand = RecordedHand(0), recorded_motion(user.operator, path, at.start, at.tick_s)
    traces = simulate_one(scenario, Conditions(hands={user.name: hand}))
    (found,), server = traces.users, traces.server
    assert np.abs(server.f_s[0]).max() > 1.0
    work_j = np.cumsum(np.sum(found.f_applied[:-1] * np.diff(found.x_m, axis=0), axis=-1))
    assert work_j.min() >= -2.0 * user.master.store_j
    apart = found.x_m[-1, 0] - server.x_s[0][-1, 0]
    assert abs(apart) < (0.2e-3 if not network else 0.5e-3)
