# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in virtual time: the same bits every time, batches equal single runs, the
dissertation's numbers."""

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
