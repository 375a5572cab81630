# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions on the strict channel over bad networks: passive, no drift, force within bounds, and
outages survived.
"""

import copy

import numpy as np
import pytest
from support.simulated import judged, late_s, least_j, simulated

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.figures import link_charts
from pmwvc_analysis.figures.recorded import conditions
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_analysis.verdicts.outcomes import outcomes
from pmwvc_bringup import scenarios as files
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.simulation.session import SteppedSession

B, STEP_S = 25.0, 0.008
LEAST_J = -1e-9
DISTURBED = {
    "jitter": ("link.jitter=uniform", "link.jitter_s=0.012"),
    "loss that begins in the carry": ("seed=4", "link.schedule=2.5 loss=0.1; 5.5 base"),
    "loss and duplicates": ("link.loss=0.2", "link.duplicate=0.1"),
    "reordering": ("link.jitter=uniform", "link.jitter_s=0.016", "link.keep_order=false"),
    "loss, short silence": ("link.loss=0.05", "safety.timeout_s=0.03"),
}
LOSS = ("link.loss=0.1",)
SOON = "task.move_s=2.5"  # there until 5.5 s; back from 6.5 s on


def ran(*settings, duration_s=7.0, out=()):
    """Run ``carry_16ms``; ``out``: stretches of time [s] in which no packet passes."""
    texts = ["channel=strict", SOON, *settings]
    scenario = files.load("carry_16ms", settings_texts=texts, duration_s=duration_s)
    batch = SteppedSession(scenario)
    for user in batch.users:
        for link in (user.up, user.down):
            cut(link, out)
    batch.run(lambda _: None)
    return batch, batch.traces(), scenario


def cut(link, out):
    send = link.send

    def pass_on(packet, now_ns):
        if not any(start <= now_ns * 1e-9 < end for start, end in out):
            send(packet, now_ns)

    link.send = pass_on


def apart_m(traces, user):
    """Distance of device and avatar over the ticks."""
    steps = np.asarray(traces.server.x_s[user])[:, 0]
    x_m = traces.users[user].x_m[:, 0]
    return np.abs(x_m - np.repeat(steps, 8)[: len(x_m)])


@pytest.mark.parametrize("name", DISTURBED)
def test_a_disturbed_link_neither_drifts_nor_kicks(name):
    calm = files.load("carry_16ms", settings_texts=["channel=strict", SOON], duration_s=7.0)
    most_n = 1.5 * max(np.abs(user.f_applied).max() for user in simulated(calm).users)
    batch, traces, scenario = ran(*DISTURBED[name])
    for i, (user, energy) in enumerate(
        zip(traces.users, user_energies(traces, scenario), strict=True)
    ):
        assert least_j(energy) >= LEAST_J
        force = np.abs(user.f_applied[-500:]).mean()
        allowed = force * (late_s(batch, i) + STEP_S) / (2.0 * B) + 1e-3
        distance = apart_m(traces, i)
        assert distance[-500:].mean() <= allowed
        assert np.abs(user.f_applied).max() <= most_n
    assert budget(traces, scenario).closes
    assert inconsistencies(traces, scenario) == []


def test_the_force_starts_from_zero_only_behind_a_restart_or_a_release():
    batch, traces, _ = ran("safety.release_s=1", duration_s=6.5, out=[(4.0, 5.8)])
    user = traces.users[0]
    f = np.abs(user.f_applied[:, 0])
    assert f[3900] > 1.0
    assert f[5700] < 0.05  # let go after release_s
    back = f[5800:6000]
    assert back.max() < 1.0  # and not at once
    assert batch.users[0].loop.state == SafetyState.COUPLED


def test_position_feedback_paid_by_the_node_brings_device_and_avatar_together():
    rests = ("task.rest_s=2", *LOSS)
    lent = ("master.position.gain=20", "master.position.storage_j=0.005")
    _, traces, scenario = ran(*lent, *rests)
    for i, energy in enumerate(user_energies(traces, scenario)):
        assert apart_m(traces, i)[-500:].mean() < 0.2e-3
        assert energy.joint.minimum_j >= -0.005 + LEAST_J
        assert energy.joint.minimum_j < 0.0  # the loan is used
    _, none, _ = ran(*rests)
    assert apart_m(none, 0)[-500:].mean() > 1e-3


def test_an_offset_is_predicted_where_packets_come_evenly_and_left_open_elsewhere():
    late = ("server.coupling=one_step_delay",)
    for settings, hit in (((), True), (late, True), (LOSS, None)):
        texts = ["channel=strict", *settings]
        scenario = files.load("carry_16ms", settings_texts=texts, duration_s=4.0)
        found = [each for each in outcomes(scenario, judged(scenario)) if each.what == "offset"]
        assert [each.hit for each in found] == [hit, hit]
        assert ("how late packets come" in found[0].text) == (hit is None)


def test_the_report_shows_both_ways_of_the_link_and_no_filter_that_is_not_there():
    scenario = files.load("carry_16ms", settings_texts=["channel=strict"], duration_s=4.0)
    traces, result = simulated(scenario), judged(scenario)
    for panel in link_charts.energy(traces, scenario).panels:
        assert [line.label[:4] for line in panel.lines] == ["up, ", "down"]
    ways = [each for each in result["passivity"]["ports"] if each["part"] in ("up", "down")]
    assert len(ways) == 4 and min(each["least_balance_j"] for each in ways) >= LEAST_J
    words = conditions(scenario, "simulated")
    assert "channel strict" in words and "filter" not in words and "hold" not in words
    plain = conditions(files.load("carry_16ms", settings_texts=["channel=plain"]), "simulated")
    assert "hold foh" in plain


def test_all_ports_are_predicted_passive_where_the_accounts_know_the_motion():
    def said(*settings, duration_s=4.0):
        texts = ["channel=strict", *settings]
        scenario = files.load("carry_16ms", settings_texts=texts, duration_s=duration_s)
        result = judged(scenario)
        return [each for each in outcomes(scenario, result) if each.what == "passivity"], result

    for settings in ((), LOSS):
        (found,), result = said(*settings)
        assert found.hit and result["passivity"]["passive"]
    for unknown in ("device.encoder_step_m=1e-4", "channel=plain"):
        assert said(unknown, duration_s=2.0)[0] == []
    scenario = files.load("carry_16ms", settings_texts=["channel=strict"], duration_s=4.0)
    broken = copy.deepcopy(judged(scenario))
    unknown = "a port was not judged"
    for passive, hit, words in ((None, None, unknown), (False, False, "NOT")):
        broken["passivity"]["ports"][0]["passive"] = passive
        (found,) = [each for each in outcomes(scenario, broken) if each.what == "passivity"]
        assert found.hit is hit and words in found.text
