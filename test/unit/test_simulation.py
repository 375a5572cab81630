# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in virtual time: the same bits every time, batches equal single runs, the
dissertation's numbers."""

import dataclasses

import numpy as np
import pytest
from support.plain import load
from support.simulated import quick_summary

from pmwvc_core.network.link import Link
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.session import simulate, simulate_one
from pmwvc_core.transport.packet import size_bytes

SHORT = {
    "name": "short",
    "duration_s": 1.5,
    "controller": "pmwvc",
    "channel": "plain",
    "users": 2,
    "task": {"kind": "hold", "grip_s": 0.1, "grip_rise_s": 0.2},
}


def arrays_of(traces):
    """Every array of a session, in a fixed order."""
    for part in (*traces.users, traces.server, *traces.packets.values(), *traces.fates.values()):
        for field in dataclasses.fields(part):
            value = getattr(part, field.name)
            values = value.values() if isinstance(value, dict) else value
            if isinstance(value, np.ndarray):
                yield f"{field.name}", value
            elif isinstance(value, (list, dict)):
                for each in values:
                    if isinstance(each, np.ndarray):
                        yield f"{field.name}", each


def test_a_session_run_twice_is_identical_to_the_last_bit():
    scenario = parse_scenario(
        SHORT | {"link": {"delay_s": 0.01, "jitter": "normal", "jitter_s": 0.003, "loss": 0.1}}
    )
    first, second = simulate_one(scenario), simulate_one(scenario)
    count = 0
    for (name, one), (_, other) in zip(arrays_of(first), arrays_of(second), strict=True):
        assert one.tobytes() == other.tobytes(), name
        count += one.size
    assert count > 50_000


def test_results_come_in_the_order_asked_for_whatever_the_batches():
    scenarios = [
        parse_scenario(SHORT | {"duration_s": duration}, overrides={"server.object_mass": mass})
        for duration, mass in ((0.2, 1.0), (0.1, 1.0), (0.2, 2.0), (0.1, 2.0))
    ]
    shares = []
    kept = simulate(scenarios, keep=lambda traces, _: traces.duration_s, progress=shares.append)
    assert kept == [0.2, 0.1, 0.2, 0.1]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


# App. B Fig. 5. The lag of the wave path (filter 19.5 ms, packet 1 ms, hold 7 ms, network) less
# the 2 T_VE by which the avatar of the one-step-delay coupling runs ahead.
@pytest.mark.parametrize(("delay_ms", "lag_ms"), [(0, 27.5), (16, 59.5), (24, 75.5)])
@pytest.mark.parametrize(("coupling", "ahead_ms"), [("one_step_delay", 16), ("implicit", 0)])
def test_the_controlled_experiment_settles_where_the_closed_form_gives(
    delay_ms, lag_ms, coupling, ahead_ms
):
    scenario = load(
        f"thesis_controlled_{delay_ms}ms",
        settings_texts=[f"server.coupling={coupling}"],
        duration_s=8.0,
    )
    traces = simulate_one(scenario)
    result = quick_summary(traces, scenario)
    assert result["stable"]
    press = [np.abs(traces.server.f_s[i][-1, 0]) / 500.0 for i in range(2)]
    assert press == pytest.approx([2e-3, 2e-3], rel=1e-6)
    for user, sign in zip(result["users"], (1, -1), strict=True):
        assert user["passive"]
        assert user["force_final_n"] == pytest.approx(sign, rel=1e-6)
        assert user["avatar_force_final_n"] == pytest.approx(sign, rel=1e-6)
        lead_m = (lag_ms - ahead_ms) * 1e-3 / (2 * 25.0)
        assert user["drift_m"] == pytest.approx(sign * lead_m, abs=1.5e-5)


def test_the_links_of_a_session_have_the_fates_of_the_link_alone():
    scenario = parse_scenario(SHORT | {"link": {"loss": 0.2, "duplicate": 0.1, "delay_s": 0.005}})
    seen = simulate_one(scenario).fates["user2/down"]
    link = Link(scenario.users[1].link_down, seed=(scenario.seed, 1, 1))
    times = seen.time_in_ns[seen.fate != 2]
    alone = [f for time in times for f in link.send(None, int(time), size_bytes=size_bytes(1))]
    assert [int(fate.kind) for fate in alone] == seen.fate.tolist()
    assert {0, 1, 2} == set(seen.fate.tolist())


def test_without_operators_nothing_moves_and_no_energy_flows():
    scenario = parse_scenario(SHORT | {"operator": {"kind": "none"}})
    traces = simulate_one(scenario)
    assert not traces.server.x_o.any()
    assert all(not user.f_applied.any() and not user.u_m.any() for user in traces.users)
