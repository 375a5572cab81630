# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy balances of the channel from traces."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from support import handmade
from support import plain as files
from support.handmade import DELAY_FRAMES, FRAME_S, IN_FLIGHT_J, TICKS
from support.simulated import simulated

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.verdicts.passivity import passivity, verdict
from pmwvc_core.law.motion import advanced, motion

PER_TICK = "time_s tick x_m xd_m f_h f_m f_applied u_m u_m_lp v_m lateness_s compute_s".split()


def test_a_pure_delay_holds_what_is_in_flight():
    for entry in user_energies(handmade.session()):
        assert entry.up.balance_j[-1] == pytest.approx(DELAY_FRAMES * IN_FLIGHT_J, rel=1e-9)
        assert entry.down.balance_j[-1] == pytest.approx(
            (DELAY_FRAMES + 1) * IN_FLIGHT_J, rel=1e-9
        )
        assert entry.passive


def test_a_channel_that_amplifies_is_not_passive():
    gain = 1.2
    up = user_energies(handmade.session(gain=gain))[0].up
    judged = up.judged("user1", "up")
    assert judged.passive is False
    # at rest each frame brings one and gives out gain^2
    steps = np.diff(up.balance_j)[-50:]
    np.testing.assert_allclose(steps, (1.0 - gain**2) * IN_FLIGHT_J, rtol=1e-9)
    assert up.minimum_j == pytest.approx(up.balance_j.min())
    assert judged.least_s == pytest.approx(up.time_s[-1])


@pytest.mark.parametrize("seed", range(8))
def test_gaps_anywhere_change_no_balance(seed):
    """The recorder loses random blocks and steps of the server: what is judged does not change."""
    random = np.random.default_rng(seed)
    whole, holed = handmade.session(duration_s=2.0), handmade.session(duration_s=2.0)
    for start in sorted(random.choice(240, size=4, replace=False), reverse=True):
        stop = min(start + int(random.integers(1, 12)), len(holed.users[0].block_time_s))
        handmade.without_blocks(holed.users[0], slice(int(start), stop))
    kept = random.random(len(holed.server.time_s)) > 0.2
    server = holed.server
    for name in ("time_s", "step", "periods_s"):
        setattr(server, name, getattr(server, name)[kept])
    for name in ("f_s", "xd_s", "energy_u_s", "energy_v_s"):
        setattr(server, name, [values[kept] for values in getattr(server, name)])
    for expected, found in zip(user_energies(whole), user_energies(holed), strict=True):
        assert found.passive
        assert len(found.up.time_s) > 50
        for way in ("up", "down", "joint"):
            before, after = getattr(expected, way), getattr(found, way)
            same = np.isin(before.time_s, after.time_s)
            np.testing.assert_allclose(after.balance_j, before.balance_j[same], atol=1e-12)


def test_a_late_server_step_is_balanced_when_it_really_ran():
    traces = handmade.session()
    traces.metadata["server_lateness_s"] = np.full(len(traces.server.time_s), FRAME_S)
    up = user_energies(traces)[0].up
    assert up.balance_j[-2] == pytest.approx((DELAY_FRAMES + 1) * IN_FLIGHT_J, rel=1e-9)


def test_work_done_on_the_hand_is_no_restart():
    traces = handmade.session()
    user = traces.users[0]
    user.x_m = user.x_m + 0.02 * np.sin(2 * np.pi * user.time_s)[:, np.newaxis]
    work = np.cumsum(np.sum(user.f_applied[:-1] * np.diff(user.x_m, axis=0), axis=-1))
    work = np.append(work, work[-1])
    user.energy["device"] = work[TICKS - 1 :: TICKS]
    assert np.diff(user.energy["device"]).min() < 0.0
    found = user_energies(traces)[0].joint
    np.testing.assert_allclose(found.energy_in_j[1:], work[TICKS - 1 : -1 : TICKS], atol=1e-12)


def test_without_waves_only_the_joint_balance_is_there():
    traces = handmade.session()
    for user in traces.users:
        user.u_m, user.v_m = np.zeros_like(user.u_m), np.zeros_like(user.v_m)
    entry = user_energies(traces)[0]
    assert entry.up is None
    assert entry.down is None
    assert entry.passive


def test_a_tick_counts_when_it_really_ran():
    traces = handmade.session()
    for user in traces.users:
        user.lateness_s[-TICKS:] = 2 * FRAME_S  # the packet of the block before is late as well
    up = user_energies(traces)[0].up
    assert up.balance_j[-1] == pytest.approx((DELAY_FRAMES - 1) * IN_FLIGHT_J, rel=1e-9)


@pytest.mark.parametrize("first", [True, False])
def test_a_master_whose_trace_breaks_off_or_was_found_late_is_judged_for_that_half(first):
    traces = handmade.session()
    user, whole = traces.users[0], user_energies(traces)[0].up.balance_j
    half = len(user.tick) // 2
    ticks, blocks = (
        slice(None, each) if first else slice(each, None) for each in (half, half // TICKS)
    )
    for name in PER_TICK:
        setattr(user, name, getattr(user, name)[ticks])
    user.block_time_s = user.block_time_s[blocks]
    user.energy = {name: sums[blocks] for name, sums in user.energy.items()}
    found = user_energies(traces)[0]
    assert found.passive
    assert not first or found.up.time_s[-1] == pytest.approx(user.time_s[-1] + user.tick_s)
    rows = len(found.up.time_s)
    expected = whole[:rows] if first else whole[-rows:]
    np.testing.assert_allclose(found.up.balance_j, expected, atol=1e-12)


def restarted(again, *, lost=0):
    """A master started again at block ``again``: its sums, as recorded, begin at zero and are
    continued by the reader; the last ``lost`` blocks before it were never published.
    """
    traces = handmade.session()
    user = traces.users[0]
    user.tick[again * TICKS :] -= user.tick[again * TICKS]
    for sums in user.energy.values():
        sums[again:] -= sums[again - 1] - sums[again - 1 - lost]
    if lost:
        handmade.without_blocks(user, slice(again - lost, again))
    return traces


def test_the_balances_end_where_a_master_was_started_again():
    traces, whole = restarted(200, lost=3), user_energies(handmade.session())[0]
    found = user_energies(traces)[0]
    (again,) = found.unjudged
    assert again.why == "user1 was started again"
    assert again.start_s == pytest.approx(197 * FRAME_S, abs=2 * FRAME_S)
    assert again.end_s == pytest.approx(traces.server.time_s[-1], abs=FRAME_S)
    for way in ("up", "down", "joint"):
        balance = getattr(found, way)
        rows = len(balance.time_s)
        assert balance.time_s[-1] < again.start_s < balance.time_s[-1] + 2 * FRAME_S
        np.testing.assert_allclose(balance.balance_j, getattr(whole, way).balance_j[:rows])
    assert found.passive is None  # what comes later is not known
    other = user_energies(traces)[1]
    assert other.passive and other.unjudged == []
    # the control: what was made before is a violation all the same
    traces.server.energy_u_s[0][100:] += 5e-3
    assert user_energies(traces)[0].passive is False


def test_the_balances_end_where_the_server_was_started_again():
    traces, whole = handmade.session(), user_energies(handmade.session())[0]
    traces.server.step[250:] -= traces.server.step[249]
    judged = passivity(traces, handmade.scenario(), None)
    for entry in user_energies(traces):
        assert len(entry.up.time_s) == 250 and entry.passive is None
        np.testing.assert_allclose(entry.up.balance_j, whole.up.balance_j[:250], atol=1e-12)
    again_s = traces.server.time_s[250]
    for owner in ("user1", "user2", "server"):
        assert judged.passive(owner) is None
        text = f"passivity not judged: from {again_s:.2f} to "
        assert verdict(judged, owner).startswith(text)
        assert verdict(judged, owner).endswith("server was started again")
    # the control: what was made before is a violation all the same
    traces.server.energy_u_s[0][100:] += 1.0
    assert passivity(traces, handmade.scenario(), None).passive("user1") is False


ENCODER = {"device.encoder_step_m": 5.5e-5, "device.velocity": "euler"}


def carried(**settings):
    values = {"master.position.gain": 20.0, **ENCODER, **settings}
    texts = [f"{name}={value}" for name, value in values.items()]
    scenario = files.load("carry_16ms", settings_texts=texts, duration_s=6.0)
    return copy.deepcopy(simulated(scenario)), scenario


def true_motion(user, scenario):
    """Where the device of a user really was: its motion under the recorded forces."""
    known = next(each for each in scenario.users if each.name == user.name)
    device = known.device
    p = motion(device.mass, device.damping, user.tick_s)
    x, xd, found = known.side * (scenario.server.object_size_m / 2 + known.contact.gap_m), 0.0, []
    for force in (user.f_h - user.f_applied)[:, 0].tolist():
        found.append(x)
        (x,), (xd,) = advanced((x,), (xd,), (force,), p)
    return np.array([*found, x])


def test_behind_an_encoder_the_hand_is_judged_by_its_true_motion():
    traces, scenario = carried()
    for user, found in zip(traces.users, user_energies(traces, scenario), strict=True):
        x = true_motion(user, scenario)
        assert np.abs(x[:-1] - user.x_m[:, 0]).max() <= 5.5e-5 / 2 + 1e-12
        work = np.cumsum(user.f_applied[:, 0] * np.diff(x))
        np.testing.assert_allclose(
            found.joint.energy_in_j[1:], work[TICKS - 1 : -1 : TICKS], atol=1e-10
        )
        assert not found.joint.resolution_j.any()
        # the controls: velocity measured, and positions measured, tell another story
        booked = np.sum(user.f_applied * user.xd_m) * user.tick_s
        assert booked > work[-1] + 0.01
        assert np.sum(user.f_applied[:-1] * np.diff(user.x_m, axis=0)) < work[-1] - 0.01


def test_a_real_encoder_leaves_the_work_open_and_nothing_is_claimed():
    traces, known = carried()
    real = [
        replace(user, given_device=replace(user.device, plugin="real")) for user in known.users
    ]
    scenario = replace(known, users=tuple(real))
    for user in traces.users:  # its master knows no more than the encoder
        moved = np.diff(user.x_m, axis=0, append=user.x_m[-1:])
        user.energy["device"] = np.cumsum(np.sum(user.f_applied * moved, axis=-1))[
            TICKS - 1 :: TICKS
        ]
        found = next(e for e in user_energies(traces, scenario) if e.name == user.name)
        true = np.cumsum(user.f_applied[:, 0] * np.diff(true_motion(user, scenario)))
        off = np.abs(found.joint.energy_in_j[1:] - true[TICKS - 1 : -1 : TICKS])
        assert (off <= found.joint.resolution_j[1:]).all()
        assert off.max() > 0.05 * found.joint.resolution_j.max()
        assert found.passive is None
    # the control: without steps there is nothing open
    traces, scenario = carried(**{"device.encoder_step_m": 0.0, "device.velocity": "exact"})
    assert all(found.passive for found in user_energies(traces, scenario))
