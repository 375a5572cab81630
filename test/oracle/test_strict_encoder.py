# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The strict channel behind an encoder whose differences are the velocity: the grip holds, and the
work that is counted is hardly more than the true one.
"""

import copy

import numpy as np
import pytest
from support.laws import alter_laws
from support.simulated import simulated

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.criterion import bounded
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.prediction.text import encoder_lines
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup import scenarios as files
from pmwvc_core.law.port.counts import SLOW_S, counts, resting_counts
from pmwvc_core.master.count_bound import LARGEST_IMPEDANCE, LARGEST_RATIO
from pmwvc_core.simulation.session import simulate_one

STEP_M, TICK_S = 55e-6, 0.001
COARSE = (f"device.encoder_step_m={STEP_M}", "device.velocity=euler")


def as_measured(s, x, xd, h):
    """The control: position and velocity as measured."""
    jump = x - s.seen
    return s._replace(x=x, seen=x), (jump, jump, xd)


COARSER = ("device.encoder_step_m=1e-4", "device.velocity=euler")
UNLENT = ("master.store_j=0", "server.store_j=0")  # what counts give out is not hidden by E0


def carry(*settings):
    texts = ["task.move_s=2.5", *UNLENT, *settings]  # there until 5.5 s
    return files.load("carry_16ms", settings_texts=texts, duration_s=6.5)


def held(traces, user=0):
    """Grip force [N], and distance of device and avatar [m], in the last second."""
    x_s = np.repeat(np.asarray(traces.server.x_s[user])[:, 0], 8)
    x_m, f = traces.users[user].x_m[:, 0], traces.users[user].f_applied[:, 0]
    return np.abs(f[-1000:]).mean(), np.abs(x_m - x_s[: len(x_m)])[-1000:].mean()


@pytest.mark.parametrize("impedance", [10.0, 50.0])
def test_the_grip_holds_behind_a_coarse_encoder(impedance):
    setting = f"master.impedance={impedance}"
    force_n, apart_m = held(simulated(carry(setting)))
    scenario = carry(setting, *COARSE)
    traces = simulated(scenario)
    for i, energy in enumerate(user_energies(traces, scenario)):
        coarse_n, coarse_m = held(traces, i)
        assert coarse_n > 0.9 * force_n
        assert coarse_m < apart_m + 1e-3
        assert min(energy.up.minimum_j, energy.down.minimum_j) >= -1e-9
        assert energy.joint.minimum_j >= -0.1 * impedance * STEP_M**2 / TICK_S  # true motion
    assert budget(traces, scenario).closes
    assert inconsistencies(traces, scenario) == []


def test_a_force_of_the_difference_quotient_loses_the_grip(monkeypatch):
    """The control."""
    alter_laws(monkeypatch, port__strict_master__counts=as_measured)
    setting = "master.impedance=50"
    force_n, apart_m = held(simulate_one(carry(setting, *COARSE)))
    assert force_n < 0.5 * held(simulated(carry(setting)))[0]
    assert apart_m > 5e-3


def given_j(scenario):
    """Energy that the ports of the hands gave out beyond what they took in [J], of the worst."""
    energies = user_energies(simulate_one(scenario), scenario)
    return max(-each.joint.minimum_j for each in energies)


def coarse(impedance, step_m):
    texts = [f"master.impedance={impedance}", f"device.encoder_step_m={step_m}", COARSE[1]]
    texts += UNLENT
    return files.load("carry_16ms", settings_texts=texts, duration_s=4.0)


def test_a_device_does_not_swing_about_a_count(monkeypatch):
    """The control is a slower tracker."""
    one_j = 80.0 * STEP_M**2 / TICK_S
    assert given_j(coarse(80.0, STEP_M)) <= 0.1 * one_j
    alter_laws(monkeypatch, port__counts__TRACKED=0.57)
    assert given_j(coarse(80.0, STEP_M)) > one_j


ALONE = (
    *COARSE,
    "channel=strict",
    "link.delay_s=0.016",
    "master.rate_drop=1",  # no ramp, which calms it
    "server.period_s=0.001",
    "device.damping=2",
    "operator.kind=sinusoid",
    "operator.frequency_hz=0.3",
)


def test_a_fast_swing_of_a_device_alone_counts_the_positions_measured(monkeypatch):
    """The control: the work over the tracked position feeds the swing, by 20 mJ at any force. What
    is left is chaotic, so two forces are taken together.
    """

    def fed_j(slow_s):
        alter_laws(monkeypatch, port__counts__SLOW_S=slow_s)
        forces = ([*UNLENT, *ALONE, f"operator.force={force}"] for force in (0.3, 0.5))
        return sum(given_j(files.load("wall", settings_texts=f, duration_s=5.0)) for f in forces)

    control_j = fed_j(0.0)
    assert control_j > 1e-2
    assert fed_j(SLOW_S) < 0.05 * control_j


def test_what_a_port_behind_counts_gives_out_is_said_before_the_session():
    coarser = [*UNLENT, *COARSER, "user2.operator.kind=none"]
    scenario = files.load("carry_16ms", settings_texts=coarser, duration_s=3.0)
    one, other = encoder_lines(scenario)
    assert one.startswith("user1: velocities are differences of counts of 100 um")
    assert "b h/m = 0.1 and frames of 8 ms. With a hand on the device" in one
    assert (
        "gives out at most 0.1 b q^2/h = 0.025 mJ more than it took in (measured, not proved)"
        in one
    )
    assert "operator.kind = none) no bound is known." in other
    for settings in (("device.encoder_step_m=1e-4",), ("channel=plain", *coarser)):
        assert encoder_lines(files.load("carry_16ms", settings_texts=settings)) == []


def anyone(seed):
    """A device behind counts for which the bound holds, with any hand, contact, link and rate."""
    rng = np.random.default_rng(seed)

    def between(least, most):
        return float(np.exp(rng.uniform(np.log(least), np.log(most))))

    mass, frame = between(0.1, 1.0), int(rng.choice([4, 8, 16]))
    settings = {
        "channel": "strict",
        "device.mass": mass,
        "device.velocity": "euler",
        "device.encoder_step_m": between(5e-6, 2e-4),
        "device.friction": rng.choice([0.0, 0.1]),
        "master.impedance": min(
            rng.uniform(0.02, LARGEST_RATIO) * mass / TICK_S, LARGEST_IMPEDANCE
        ),
        "master.rate_drop": frame,
        "server.period_s": frame * TICK_S,
        "server.contact_stiffness": between(200.0, 2000.0),
        "operator.stiffness": between(30.0, 500.0),
        "operator.damping": between(2.0, 30.0),
        "operator.squeeze": between(0.7, 3.0),
        "link.delay_s": rng.choice([0.001, 0.004, 0.016, 0.04]),
        "link.loss": rng.choice([0.0, 0.05]),
    }
    name = "wall" if rng.random() < 0.3 else "carry_16ms"
    texts = [f"{key}={value}" for key, value in settings.items()]
    texts += UNLENT
    return files.load(name, settings_texts=texts, duration_s=4.0)


@pytest.mark.parametrize("seed", range(4))
def test_a_device_within_the_limits_gives_out_no_more_than_the_bound(seed):
    scenario = anyone(seed)
    assert given_j(scenario) <= bounded(scenario.users[0], scenario).given_j


def test_a_light_device_is_promised_nothing_and_gives_out_more():
    """The control: b h/m = 0.4; a frame of 2 ms promises nothing either."""
    scenario = coarse(100.0, STEP_M)
    assert bounded(scenario.users[0], scenario) is None
    quick = files.load("carry_16ms", settings_texts=["master.rate_drop=2", *COARSE])
    assert bounded(quick.users[0], quick) is None
    assert given_j(scenario) > 10.0 * 0.1 * 100.0 * STEP_M**2 / TICK_S
    assert all(
        "b h/m = 0.4 " in line and "known up to master.impedance = 37.5 N s/m" in line
        for line in encoder_lines(scenario)
    )


def test_the_report_names_bound_and_amount():
    scenario = coarse(25.0, 100e-6)
    traces = simulated(scenario)
    result = summary(traces, scenario)
    assert result["passivity"]["passive"]
    assert "passive within the encoder's bound of 25 µJ" in result["passivity"]["text"]["user1"]
    assert result["passivity"]["components"] == []
    port = next(p for p in result["passivity"]["ports"] if p["part"] == "hand_port")
    assert port["encoder_bound_j"] == pytest.approx(25e-6)
    assert -port["encoder_bound_j"] <= port["least_balance_j"] < 0.0


@pytest.mark.parametrize(
    ("part", "given_j"), [("energy_u_s", 3e-6), ("energy_v_s", 3e-6), ("device", 3e-5)]
)
def test_the_bound_of_counts_hides_no_other_leak(part, given_j):
    """The control: links have no part in the bound, and the port of the hand no more than that."""
    scenario = coarse(25.0, 100e-6)
    traces = copy.deepcopy(simulated(scenario))
    if part == "device":
        traces.users[0].energy[part] -= given_j
    else:
        last = traces.server.users.index("user1")
        getattr(traces.server, part)[last][20] += (1 if part == "energy_u_s" else -1) * given_j
    assert passivity(traces, scenario, None).passive("user1") is False
    assert passivity(simulated(scenario), scenario, None).passive("user1") is True


def works(steps, *, seed):
    """Work [J] of a damper of 25 N s/m behind counts, on a hand's motion of up to 4 cm/s: the true
    one; that of the positions counted, followed and in between.
    """
    rng = np.random.default_rng(seed)
    time_s = np.arange(steps) * TICK_S
    tones = rng.uniform(0.2, 2.0, 4), rng.uniform(0.0, 2.0 * np.pi, 4)
    x = sum(0.0012 * np.sin(2.0 * np.pi * f * time_s + p) for f, p in zip(*tones, strict=True))
    found, force, before = np.zeros(4), 0.0, None
    for k, true_m in enumerate(x):
        read = float(np.floor(true_m / STEP_M + 0.5) * STEP_M)
        if before is None:
            place = resting_counts(read)
        else:
            place, (dx, worked, xd) = counts(place, read, (read - before[1]) / TICK_S, TICK_S)
            moved = np.array([true_m - before[0], read - before[1], dx, worked])
            found += force * moved
            force = 25.0 * xd
        before = (x[k], read)
    return found


@pytest.mark.parametrize("seed", range(3))
def test_the_work_counted_is_below_the_true_one_by_less_than_over_counts(seed):
    true, counted, followed, between = works(20_000, seed=seed)
    assert counted < true - 5e-3  # half a milliwatt and more
    assert between < true
    assert abs(between - true) < 0.7 * abs(counted - true)
    assert counted < between < followed
