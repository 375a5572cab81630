# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Everything recorded comes back equal, and a replay is its recording to the last bit: over links
that corrupt, lose, repeat and reorder, with loops that wake late and rates that change in flight.
The recordings are those of live loops, in virtual time. What one lacks makes no verdict: no hole
makes a port or a component active.
"""

import numpy as np
import pytest
from hypothesis import Phase, assume, example, given, settings
from hypothesis import strategies as st
from support import plain as files
from support.rewriting import raw, unequal, written

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.parameter_events import taken_over
from pmwvc_analysis.recording.reader import read_session
from pmwvc_analysis.replay.run import exact, replay
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_bringup import scenarios
from pmwvc_core.errors import ScenarioError
from pmwvc_core.frame import LIVE
from pmwvc_core.scenario.names import read_changes
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.session import simulate_one

TICKS = 640
MS = 1_000_000
LINK = (
    *("link.delay_s=0.008", "link.jitter=normal", "link.jitter_s=0.004", "link.keep_order=false"),
    *("link.loss=0.1", "link.duplicate=0.1", "link.corrupt=0.05"),
)
change = st.one_of(
    st.tuples(st.sampled_from(["user1", "user2"]), st.integers(2, 20)).map(
        lambda drawn: f"{drawn[0]}.master.rate_drop={drawn[1]}"
    ),
    st.integers(2, 20).map(lambda ms: f"server.period_s={ms * 1e-3:g}"),
    st.sampled_from(["user1.master.impedance=30", "user1.server.contact_stiffness=800"]),
)
schedule = st.lists(st.tuples(st.floats(0.1, 0.55), change), max_size=5)


def as_live(changes, late, grid, seed, *, slept=30):
    """Return scenario and traces of a session whose loops woke late, and whose parameters were
    changed in flight at times that fall between its ticks.
    """
    texts = ("channel=strict", "task.grip_s=0.1", "safety.soft_start_s=0.05", f"seed={seed}")
    start = files.load("carry_16ms", settings_texts=(*texts, *LINK), duration_s=TICKS * 1e-3)
    text = "; ".join(f"{time_s} {words}" for time_s, words in changes)
    try:
        scenario = files.load(
            "carry_16ms",
            settings_texts=(*texts, *LINK, f"changes={text}"),
            duration_s=TICKS * 1e-3,
        )
    except ScenarioError:
        assume(False)  # the same parameter twice, to a value out of its range with others
    random = np.random.default_rng(seed)
    late_ns = random.integers(0, round(late * MS), (2, TICKS))
    ran_ns = {f"user{n + 1}": np.arange(TICKS) * MS + late_ns[n] for n in range(2)}
    ran_ns["user2"][300 : 300 + slept] = -1
    conditions = Conditions(LIVE, first={"user1": -grid}, ran_ns=ran_ns)
    traces = simulate_one(scenario, conditions)
    traces.source = "live"
    found = [(each.time_s, dict(each.values)) for each in read_changes(text)]
    traces.settings = taken_over(found, traces.users, traces.server)
    return start, traces


def of_recording(traces):
    """The parts of traces that are recorded as they are."""
    fates = {
        link: [each.epoch, each.seq, each.size_bytes, each.time_in_ns, each.fate, each.cause]
        for link, each in traces.fates.items()
    }
    users = [
        {n: value for n, value in vars(user).items() if n not in OTHERWISE}
        | {"b": user.block_ends}
        for user in traces.users
    ]
    counts = {link: (each.receivers, each.counts) for link, each in traces.receptions.items()}
    return [users, traces.server, traces.packets, traces.taken, fates, counts, traces.duration_s]


# Of processes, and ends of blocks in whose last ticks the loop slept: virtual time has them not.
OTHERWISE = ("block_number", "epoch", "grid", "block_time_s")


@settings(max_examples=5, phases=[Phase.explicit, Phase.generate])
@given(schedule, st.floats(0.1, 0.9), st.integers(0, 1000), st.integers(1, 1000))
def test_everything_recorded_comes_back_equal_and_its_replay_is_it(
    tmp_path_factory, changes, late, grid, seed
):
    scenario, traces = as_live(changes, late, grid, seed)
    folder = tmp_path_factory.mktemp("recorded")
    record_traces(folder, traces, scenario)
    again = read_session(folder)
    assert list(unequal(of_recording(traces), of_recording(again))) == []
    assert all(count["missing"] == 0 for count in again.counts.values())
    assert again.events == []
    again.settings = traces.settings
    for user in again.users:
        user.grid = 0  # in virtual time a loop's clock is the session's
    found = replay(again, scenario, scenario)
    assert exact(found.differences)
    assert min(user["ticks"] for user in found.differences) >= TICKS - 30
    assert np.array_equal(found.replayed.server.x_o, traces.server.x_o)


RATES = [(0.25, "user1.master.rate_drop=5"), (0.4011, "server.period_s=0.005")]


def test_what_was_taken_in_a_look_later_is_another_session():
    """The control of the looks; without a record of them a link is simulated."""
    scenario, traces = as_live(RATES, 0.9, 77, 3)
    assert exact(replay(traces, scenario, scenario).differences)
    down = traces.taken["user1/down"]
    down.row = np.minimum(down.row + 1, len(traces.users[0].time_s) - 1)
    assert not exact(replay(traces, scenario, scenario).differences)
    traces.taken.clear()
    notes = replay(traces, scenario, scenario).prescribed.notes
    assert "user1/down: its receiver was not recorded, so this link is simulated" in notes


def test_what_was_taken_over_a_frame_earlier_is_another_session():
    """The control of the changes."""
    scenario, traces = as_live(RATES, 0.9, 77, 3)
    traces.settings = [(time_s - 0.03, values) for time_s, values in traces.settings]
    found = replay(traces, scenario, scenario)
    assert not exact(found.differences)
    assert min(user["first_s"] for user in found.differences if user["first_s"]) > 0.2


def test_a_recorded_force_stays_at_its_ticks_behind_a_long_pause():
    """The device makes up for 0.1 s of a pause; the force of the hand then is not known."""
    scenario, traces = as_live([], 0.5, 0, 3, slept=250)
    operator = replay(traces, scenario, scenario, hand="operator")
    assert exact(operator.differences)
    found = replay(traces, scenario, scenario, hand="force")
    assert not exact(found.differences)
    (first,) = [user for user in found.differences if user["name"] == "user2"]
    assert first["first_s"] == pytest.approx(0.55)
    assert first["first_signals"]
    before, after = traces.users[1], found.replayed.users[1]
    assert np.array_equal(before.f_h[: len(after.f_h)], after.f_h)


HOLED_S = 2.4
KINDS = {
    "plain": ("channel=plain",),
    "strict, loss": ("link.loss=0.05", "link.jitter_s=0.004"),
    "tdpa": ("controller=tdpa",),
}
TRACES = ("/user1/trace", "/user2/trace", "/server/trace")


@pytest.fixture(scope="module", params=KINDS.values(), ids=KINDS)
def on_disk(request, tmp_path_factory):
    """Return scenario, messages, and what the whole recording shows."""
    scenario = scenarios.load("carry_16ms", settings_texts=request.param, duration_s=HOLED_S)
    place = tmp_path_factory.mktemp("whole")
    record_traces(place, simulate_one(scenario), scenario)
    return scenario, raw(place), active(place, scenario)


def active(place, scenario):
    """Return the ports and components that gave energy out, with how much [J]."""
    traces = read_session(place)
    energies = budget(traces, scenario)
    released = energies.released if energies else ()  # no budget: too little is recorded for it
    found = [*passivity(traces, scenario, energies).ports, *released]
    return {(each.owner, each.part): each.given_j for each in found if each.passive is False}


interval = st.tuples(st.floats(0.0, HOLED_S), st.floats(0.0, HOLED_S)).map(sorted)


@settings(max_examples=3)
@example([("/user1/trace", [1.0, 2.0])])
@given(st.lists(st.tuples(st.sampled_from(TRACES), interval), min_size=1, max_size=4))
def test_a_hole_makes_nothing_active(on_disk, tmp_path_factory, lacking):
    scenario, messages, seen = on_disk
    first_ns = min(message.log_ns for message in messages)

    def kept(message):
        at_s = (message.log_ns - first_ns) * 1e-9
        return not any(t == message.topic and a <= at_s < b for t, (a, b) in lacking)

    place = written([*filter(kept, messages)], tmp_path_factory.mktemp("holed"))
    for owner_part, given_j in active(place, scenario).items():
        assert owner_part in seen, (owner_part, given_j)
        assert given_j <= seen[owner_part] + 1e-9  # no more than was seen of it
