# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy balances of the channel from traces."""

import handmade
import numpy as np
import pytest
from handmade import DELAY_FRAMES, FRAME_S, IN_FLIGHT_J, TICKS

from pmwvc_analysis.judge.energy import Balance, running, user_energies
from pmwvc_analysis.judge.passivity import TOLERANCE_J

PER_TICK = "time_s tick x_m xd_m f_h f_m f_applied u_m u_m_lp v_m lateness_s compute_s".split()


def test_a_pure_delay_holds_what_is_in_flight():
    for entry in user_energies(handmade.session()):
        assert entry.up.balance_j[-1] == pytest.approx(DELAY_FRAMES * IN_FLIGHT_J, rel=1e-9)
        assert entry.down.balance_j[-1] == pytest.approx(
            (DELAY_FRAMES + 1) * IN_FLIGHT_J, rel=1e-9
        )
        assert entry.passive


def test_both_ways_together_are_the_power_at_the_two_ports():
    for entry in user_energies(handmade.session(dof=3)):
        np.testing.assert_allclose(
            entry.joint.balance_j, entry.up.balance_j + entry.down.balance_j, atol=1e-12
        )


def test_a_channel_that_amplifies_is_not_passive():
    gain = 1.2
    up = user_energies(handmade.session(gain=gain))[0].up
    assert not up.passive
    # at rest each frame brings one and gives out gain^2
    steps = np.diff(up.balance_j)[-50:]
    np.testing.assert_allclose(steps, (1.0 - gain**2) * IN_FLIGHT_J, rtol=1e-9)
    assert up.minimum_j == pytest.approx(up.balance_j.min())
    assert up.minimum_time_s == pytest.approx(up.time_s[-1])


@pytest.mark.parametrize(("share", "passive"), [(0.99, True), (1.01, False)])
def test_the_tolerance_has_two_sides(share, passive):
    out = np.array([0.0, share * TOLERANCE_J])
    balance = Balance(np.array([0.0, 1.0]), np.zeros(2), out)
    assert balance.passive is passive


def test_a_balance_that_only_rises_has_its_minimum_at_zero():
    balance = Balance(np.array([0.0, 1.0]), np.array([1.0, 2.0]), np.zeros(2))
    assert balance.minimum_j == 0.0
    assert balance.minimum_time_s is None


def test_blocks_that_were_not_recorded_leave_no_hole():
    whole, holed = handmade.session(), handmade.session()
    user = holed.users[0]
    gone = slice(100, 120)  # blocks, while the force rises
    ticks = np.r_[slice(gone.start * TICKS, gone.stop * TICKS)]
    blocks = np.r_[gone]
    for name in ("time_s", "tick", "x_m", "xd_m", "f_h", "f_m", "f_applied", "u_m", "u_m_lp"):
        setattr(user, name, np.delete(getattr(user, name), ticks, axis=0))
    for name in ("v_m", "lateness_s", "compute_s"):
        setattr(user, name, np.delete(getattr(user, name), ticks, axis=0))
    user.block_time_s = np.delete(user.block_time_s, blocks)
    user.energy = {name: np.delete(sums, blocks) for name, sums in user.energy.items()}
    expected, found = user_energies(whole)[0], user_energies(holed)[0]
    assert found.up.balance_j[-1] == pytest.approx(expected.up.balance_j[-1], rel=1e-9)
    after = expected.up.time_s > gone.stop * FRAME_S + 1e-9
    np.testing.assert_allclose(found.up.balance_j[after], expected.up.balance_j[after], atol=1e-12)


def test_a_late_server_step_is_balanced_when_it_really_ran():
    traces = handmade.session()
    traces.metadata["server_lateness_s"] = np.full(len(traces.server.time_s), FRAME_S)
    up = user_energies(traces)[0].up
    assert up.balance_j[-2] == pytest.approx((DELAY_FRAMES + 1) * IN_FLIGHT_J, rel=1e-9)


def test_work_done_on_the_hand_is_no_restart():
    traces = handmade.session()
    user = traces.users[0]
    user.xd_m = user.xd_m + 0.1 * np.cos(2 * np.pi * user.time_s)[:, np.newaxis]
    work = np.cumsum(np.sum(user.f_applied * user.xd_m, axis=-1)) * user.tick_s
    user.energy["device"] = work[TICKS - 1 :: TICKS]
    assert np.diff(user.energy["device"]).min() < 0.0
    found = user_energies(traces)[0].joint
    np.testing.assert_allclose(found.energy_in_j[1:], work[TICKS - 1 : -1 : TICKS], atol=1e-12)


def test_running_sums_go_on_over_a_restart():
    np.testing.assert_allclose(running(np.array([0.0, 2.0, 3.0, 0.5, 1.0])), [0, 2, 3, 3.5, 4.0])


def test_without_waves_only_the_joint_balance_is_there():
    traces = handmade.session()
    for user in traces.users:
        user.u_m, user.v_m = np.zeros_like(user.u_m), np.zeros_like(user.v_m)
    entry = user_energies(traces)[0]
    assert entry.up is None
    assert entry.down is None
    assert entry.joint.passive


def test_without_the_server_there_is_no_balance():
    traces = handmade.session()
    traces.server = None
    assert user_energies(traces) == []


def test_a_tick_counts_when_it_really_ran():
    traces = handmade.session()
    for user in traces.users:
        user.lateness_s[-2 * TICKS :] = 2 * FRAME_S  # all that is late brings nothing any more
    up = user_energies(traces)[0].up
    assert up.balance_j[-1] == pytest.approx((DELAY_FRAMES - 1) * IN_FLIGHT_J, rel=1e-9)


def test_a_master_whose_trace_breaks_off_is_judged_up_to_there():
    traces = handmade.session()
    user, whole = traces.users[0], user_energies(traces)[0]
    kept = len(user.tick) // 2
    for name in PER_TICK:
        setattr(user, name, getattr(user, name)[:kept])
    user.block_time_s = user.block_time_s[: kept // TICKS]
    user.energy = {name: sums[: kept // TICKS] for name, sums in user.energy.items()}
    found = user_energies(traces)[0]
    assert found.passive
    assert found.up.time_s[-1] == pytest.approx(user.time_s[-1] + user.tick_s)
    rows = len(found.up.time_s)
    np.testing.assert_allclose(found.up.balance_j, whole.up.balance_j[:rows], atol=1e-12)


def test_a_master_that_was_started_again_is_judged_up_to_there():
    traces = handmade.session()
    user = traces.users[0]
    again = len(user.tick) // 2
    user.tick[again:] -= user.tick[again]
    found = user_energies(traces)[0]
    assert found.up.time_s[-1] == pytest.approx(user.time_s[again])


def test_a_master_that_was_found_late_is_judged_from_there():
    traces = handmade.session()
    user, whole = traces.users[0], user_energies(traces)[0]
    gone = len(user.tick) // 2
    for name in PER_TICK:
        setattr(user, name, getattr(user, name)[gone:])
    user.block_time_s = user.block_time_s[gone // TICKS :]
    user.energy = {name: sums[gone // TICKS :] for name, sums in user.energy.items()}
    found = user_energies(traces)[0]
    assert found.passive
    rows = len(found.up.time_s)
    np.testing.assert_allclose(found.up.balance_j, whole.up.balance_j[-rows:], atol=1e-12)
