# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Link effects by name: the library, and records of another package."""

import dataclasses

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.lab import offer
from support.plain import load

from pmwvc_analysis.compare.settings import tuning_of
from pmwvc_analysis.events.events import complete
from pmwvc_analysis.models.linear import NonlinearError, left_out, require_linear
from pmwvc_analysis.prediction.text import lines
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_session
from pmwvc_core import plugins
from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.network.effects import EFFECTS, Effect, LinkEffect, numbers_of, plugins_of
from pmwvc_core.network.in_flight import FateKind
from pmwvc_core.network.link import Link
from pmwvc_core.params import LinkParams, Spec
from pmwvc_core.simulation.session import simulate_one

MS = 1_000_000


class Half(Effect):
    """Loses every second packet by its own numbers."""

    def loses(self, fate):
        return self.uniform(fate) < 0.5


class Late(Effect):
    """Adds as much as its number says [s]."""

    def delay_s(self, fate):
        return numbers_of(self.params.effects)["late"]["by_s"]


class Torn(Effect):
    """Fails wherever it is asked."""

    def loses(self, fate):
        return 1 // (fate.number % 2)

    def delay_s(self, fate):
        return float("nan")

    def arrives_ns(self, fate, due_ns):
        raise SystemExit("bye")


class Moody(Late):
    """Cannot take new settings beyond a second."""

    def configure(self, params):
        super().configure(params)
        if self.params.delay_s > 1.0:
            raise RuntimeError("too far")

    def delay_s(self, fate):
        return 0.0


def unmade(params, uniform):
    """Fail."""
    raise KeyError("table")


def record(name, words, make, linear="delay", **values):
    return LinkEffect(name=name, words=words, make=make, linear=linear, **values)


BY = Spec(float, "s", low=0.0, description="delay")
RECORDS = {
    "moody": record("moody", "Moody.", Moody),
    "torn": record("torn", "Fails.", Torn),
    "unmade": record("unmade", "Fails.", unmade),
    "half": record("half", "Half is lost.", Half),
    "late": record("late", "Later.", Late, None, numbers={"by_s": BY}, random=False),
    "known": record("known", "Delays nothing.", Effect, spread_s=lambda params: 0.0),
    "stone": object(),
}


@pytest.fixture(scope="module")
def lab():
    """A laboratory's own module with records."""
    with pytest.MonkeyPatch.context() as patch:
        offer(patch, EFFECTS.plugins.group, "lab_effects", RECORDS)
        plugins.imported.cache_clear()
        plugins_of.cache_clear()
        yield
    plugins.imported.cache_clear()
    plugins_of.cache_clear()


def fates(params, seed, count=60):
    link = Link(params, seed=seed)
    return [link.send(n, n * 8 * MS) for n in range(count)], link


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**31),
    jitter=st.sampled_from(["none", "uniform", "normal"]),
    loss=st.floats(0.0, 0.5),
    duplicate=st.floats(0.0, 0.5),
)
def test_a_new_effect_changes_no_luck_of_the_others(lab, seed, jitter, loss, duplicate):
    old = LinkParams(
        delay_s=0.05,
        jitter=jitter,
        jitter_s=0.01,
        loss=loss,
        duplicate=duplicate,
        keep_order=False,
    )
    before, _ = fates(old, (seed, 0, 1))
    after, _ = fates(dataclasses.replace(old, effects="late:by_s=0.25"), (seed, 0, 1))
    for ours, theirs in zip(before, after, strict=True):
        assert [fate.kind for fate in ours] == [fate.kind for fate in theirs]
        for mine, other in zip(ours, theirs, strict=True):
            if mine.time_due_ns:  # clipped at zero delay never: 50 ms is 5 deviations
                assert other.time_due_ns - mine.time_due_ns == 250 * MS


def test_own_numbers_are_those_of_the_packet_whatever_else_is_on(lab):
    beside = LinkParams(effects="late:by_s=0.1 half", jitter="normal", jitter_s=0.01)
    lost = [
        [sent[0].kind is FateKind.LOST for sent in fates(params, seed)[0]]
        for params, seed in (
            (LinkParams(effects="half"), (7, 0, 0)),
            (beside, (7, 0, 0)),
            (LinkParams(effects="half"), (7, 0, 1)),  # another direction, other numbers
        )
    ]
    assert lost[0] == lost[1] != lost[2]
    assert 15 < sum(lost[0]) < 45


def test_effects_follow_new_settings(lab):
    link = Link(LinkParams(effects="late:by_s=0.5", keep_order=False), seed=1)
    assert link.send("a", 0)[0].time_due_ns == 500 * MS
    link.configure(LinkParams(effects="late:by_s=0.1", keep_order=False))
    assert link.send("b", 0)[0].time_due_ns == 100 * MS
    link.configure(LinkParams(keep_order=False))
    assert link.send("c", 0)[0].time_due_ns == 0


@pytest.mark.parametrize(
    ("effects", "text"),
    [
        ("moon", "not installed; there are: .*half, known, late, moody, .*link_effects"),
        ("late", "late takes by_s"),
        ("late:by_s=-1", "late: by_s = -1.0: must be >= 0 s"),
        ("late:by_s", "must be a name with its numbers"),
        ("half half", "half is given twice"),
        ("half:p=1", "half takes no numbers"),
        ("stone", "is not a link effect: it is a object"),
    ],
)
def test_what_cannot_be_used_is_refused_with_the_reason(lab, effects, text):
    with pytest.raises(ParameterError, match=text):
        Link(LinkParams(effects=effects), seed=1)
    with pytest.raises(ScenarioError, match=rf"user1.link.up.effects = .*{text}"):
        load("carry_16ms", settings_texts=[f"link.effects={effects}"])


def test_a_tuning_rule_is_unknown_behind_an_effect_whose_delay_is(lab):
    words = ["controller=virtual_coupling", "link.delay_s=0.016"]
    known, unknown = (
        load("carry_16ms", settings_texts=[*words, f"link.up.effects={effect}"])
        for effect in ("known", "half")
    )
    text = "the longest delay by half is not known"
    assert f"user1: rule 'delay' unknown: {text}." in lines(unknown, live=False)
    assert f"rule delay unknown, as {text}" in tuning_of(unknown)
    assert not any("unknown" in line for line in lines(known, live=False))


def test_where_an_effect_fails_packets_pass_without_it_and_the_faults_are_counted(lab):
    torn = LinkParams(delay_s=0.02, jitter="normal", jitter_s=0.002, effects="torn")
    ours, link = fates(torn, (5, 0, 0))
    theirs, plain = fates(dataclasses.replace(torn, effects=""), (5, 0, 0))
    kept = ours[1::2]  # 1 // 1 loses a packet of odd number, 1 // 0 fails
    assert [[fate.time_due_ns for fate in each] for each in kept] == [
        [fate.time_due_ns for fate in each] for each in theirs[1::2]
    ]
    assert all(each[0].kind is FateKind.LOST for each in ours[::2])
    assert link.faults.steps == 30 * 3
    assert link.failed.startswith("calls without the effect: 90; last: link.effects = 'torn' ")
    assert plain.failed == ""


def test_settings_that_an_effect_cannot_take_are_a_fault(lab):
    link = Link(LinkParams(effects="moody"), seed=1)
    link.configure(LinkParams(delay_s=2.0, effects="moody"))
    assert link.faults.text == "link.effects = 'moody' raised RuntimeError: too far"
    assert link.send("a", 0)[0].time_due_ns == 2000 * MS
    with pytest.raises(ParameterError, match="unmade cannot be made: KeyError: 'table'"):
        link.configure(LinkParams(effects="unmade"))


def test_a_session_goes_on_and_names_the_effect_that_failed(lab, tmp_path):
    known = load("carry_16ms", settings_texts=["link.up.effects=torn", "duration_s=0.4"])
    traces = simulate_one(known)
    failed = [each for each in complete(traces, known) if "'torn' raised" in each["what"]]
    assert [each["who"] for each in failed] == ["link user1/up", "link user2/up"]
    assert {each["kind"] for each in failed} == {"link"}
    record_traces(tmp_path / "one", traces, known)
    recorded = complete(read_session(tmp_path / "one"), known)
    assert [each for each in recorded if "'torn' raised" in each["what"]] == failed
    calm = load("carry_16ms", settings_texts=["link.up.effects=known", "duration_s=0.4"])
    assert "links" not in simulate_one(calm).metadata


def test_an_effect_without_linear_relative_is_refused_by_the_model(lab):
    scenario = load("carry_16ms", settings_texts=["link.up.effects=late:by_s=0.1"])
    text = r"up.effects = late:by_s=0.1.*--set link.up.effects="
    with pytest.raises(NonlinearError, match=text):
        require_linear(scenario)
    without_amount = load("carry_16ms", settings_texts=["link.up.effects=half"])
    require_linear(without_amount)
    assert left_out(without_amount)[0].startswith("link effect half (user1 up")
