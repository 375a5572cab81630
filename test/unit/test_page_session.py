# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A simulated session as a page sees it, live and recorded: rows, and the report's balances."""

from dataclasses import replace

import numpy as np
import pytest
from support.plain import load
from support.simulated import judged, simulated

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_view.feed import rows as rows_module
from pmwvc_view.feed.feed import Feed
from pmwvc_view.feed.verdict import Judge, verdict
from pmwvc_view.protocol.snapshot import Layout
from pmwvc_view.recorded import RecordedSession
from pmwvc_view.simulated import Simulation

MS, PERIOD_S = 1_000_000, 0.016


def run_live(scenario, ticks, poll=16):
    """Return feed and rows of a scenario that is simulated as for a page."""
    layout = Layout([user.name for user in scenario.users], scenario.dof)
    feed, rows = Feed(layout, scenario, period_ns=poll * MS), []
    simulation = Simulation(scenario)
    feed.tape.zero(0)
    for tick in range(poll, ticks + 1, poll):
        simulation.step_to(tick, feed)
        rows += feed.rows(tick * MS)
    return layout, feed, rows


@pytest.fixture(scope="module")
def carried():
    """A simulated session three ways: traces, and as a page sees it live and recorded."""
    scenario = replace(load("carry_16ms"), duration_s=6.0)
    return scenario, simulated(scenario), run_live(scenario, 6000)


def test_page_shows_the_session_that_the_simulator_gives(carried):
    _, traces, (layout, _, rows) = carried
    user, server = traces.users[0], traces.server
    for row in (each.row for each in rows):
        tick = round(float(row[1]) * 1e3)
        assert row[layout.slices["user1.x_m"]] == user.x_m[tick]
        assert row[layout.slices["object.x_o"]] == server.x_o[tick // 8]
        assert row[layout.slices["user1.f_applied"]] == user.f_applied[tick]


def test_page_of_eight_users_on_three_axes_knows_all_of_them():
    scenario = load("cube_3d", users=8, duration_s=2.0)
    layout, feed, rows = run_live(scenario, 800)
    row = rows[-1].row
    for user in scenario.users:
        assert row[layout.slices[f"{user.name}.x_m"]].shape == (3,)
        assert feed.users[user.name].state == 1
        assert np.isfinite(row[layout.slices[f"{user.name}.energy_hand_in"]]).all()
    links = np.concatenate([each.packets for each in rows])[:, 0]
    assert set(links.tolist()) == set(range(16))


def test_recorded_rows_are_those_of_the_live_page(carried):
    scenario, traces, (layout, _, rows) = carried
    whole = RecordedSession(traces, scenario, judged(scenario), snapshot_s=PERIOD_S)
    again, recorded = whole.rows, whole.packets
    for name in ("user1.x_m", "user2.f_applied", "user1.f_max", "user2.x_s", "object.x_o"):
        at = layout.slices[name]
        for row in (each.row for each in rows[1:]):
            index = round(float(row[1]) / PERIOD_S)
            assert again[index, at] == pytest.approx(row[at], abs=1e-12), (name, row[1])
    live = np.concatenate([each.packets for each in rows])
    both = {tuple(each) for each in np.round(live, 6)} & {tuple(e) for e in np.round(recorded, 6)}
    assert len(both) > 0.98 * len(recorded)


LOSSY = ("channel=strict", "link.loss=0.1", "link.jitter=uniform", "link.jitter_s=0.012")


@pytest.mark.parametrize("texts", [(), LOSSY, (*LOSSY, "master.position.gain=2.0")])
def test_page_has_the_reports_balances(texts):
    """Also those of later seconds: sums count from the start of the nodes."""
    scenario = load("carry_16ms", settings_texts=texts, duration_s=2.4)
    layout, feed, rows = run_live(scenario, 2400)
    for energy in user_energies(simulated(scenario), scenario):
        shown = feed.users[energy.name]
        assert energy.parts.keys() == shown.energy.parts.keys()
        for part, balance in shown.energy.parts.items():
            reported = energy.parts[part]
            at = np.rint(1e3 * balance.time_s).astype(int) // 8
            assert 50 < len(at) < 160 and at[-1] > 280  # a second, of 2.4
            for name in ("energy_in_j", "energy_out_j"):
                own, whole = getattr(balance, name), getattr(reported, name)
                np.testing.assert_allclose(own[:-2], whole[at][:-2], rtol=1e-12, atol=1e-15)
            assert shown.least_j[part] == pytest.approx(reported.minimum_j, abs=1e-12)
            column = f"{energy.name}.energy_{rows_module.WAYS[part]}_in"
            assert rows[-1].row[layout.slices[column]] == balance.energy_in_j[-1]
    assert all(found.passive is not False for found in feed.worst.values())


def test_balance_of_counters_read_at_two_instants_would_be_below_zero(carried):
    _, traces, _ = carried
    user, server = traces.users[0], traces.server
    naive = user.energy["u_m"][:-8] - server.energy_u_s[0][8 : len(user.energy["u_m"])]
    assert naive.min() < -1e-4


def test_verdict_is_good_only_with_every_user_judged(carried):
    """Of one user the true motion is not known."""
    scenario, _, (_, feed, _) = carried
    good, unknown = (
        verdict(feed, Judge(feed.tape, {}), scenario, exact_hands=hands, notices=[])
        for hands in (("user1", "user2"), ("user1",))
    )
    assert good["level"] == "good" and unknown["level"] == "unknown"
    assert "Energy at the hand is not judged here for user2" in unknown["verdict"]
