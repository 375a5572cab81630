# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a recording lacks makes no verdict: no hole makes a port or a component active."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from support.rewriting import raw, rewritten

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_bringup import scenarios
from pmwvc_core.simulation.session import simulate_one

LENGTH_S = 2.4
KINDS = {
    "plain": ("channel=plain",),
    "strict, loss": ("link.loss=0.05", "link.jitter_s=0.004"),
    "tdpa": ("controller=tdpa",),
}
TRACES = ("/user1/trace", "/user2/trace", "/server/trace")


@pytest.fixture(scope="module", params=KINDS.values(), ids=KINDS)
def recorded(request, tmp_path_factory):
    """Return scenario, messages, and what the whole recording shows."""
    scenario = scenarios.load("carry_16ms", settings_texts=request.param, duration_s=LENGTH_S)
    place = tmp_path_factory.mktemp("whole")
    record_traces(place, simulate_one(scenario), scenario)
    return scenario, raw(place), active(place, scenario)


def active(place, scenario):
    """Return the ports and components that gave energy out, with how much [J]."""
    traces = read_session(place)
    found = passivity(traces, scenario, budget(traces, scenario)).findings
    return {(each.owner, each.part): each.given_j for each in found if each.passive is False}


interval = st.tuples(st.floats(0.0, LENGTH_S), st.floats(0.0, LENGTH_S)).map(sorted)


@settings(max_examples=3)
@example([("/user1/trace", [1.0, 2.0])])
@given(st.lists(st.tuples(st.sampled_from(TRACES), interval), min_size=1, max_size=4))
def test_a_hole_makes_nothing_active(recorded, tmp_path_factory, lacking):
    scenario, messages, whole = recorded
    first_ns = min(message.log_ns for message in messages)

    def kept(message):
        at_s = (message.log_ns - first_ns) * 1e-9
        return not any(t == message.topic and a <= at_s < b for t, (a, b) in lacking)

    place = rewritten([*filter(kept, messages)], tmp_path_factory.mktemp("holed"))
    for owner_part, given_j in active(place, scenario).items():
        assert owner_part in whole, (owner_part, given_j)
        assert given_j <= whole[owner_part] + 1e-9  # no more than was seen of it
