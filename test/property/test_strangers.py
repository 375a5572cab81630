# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages of other programs in a recording: left out, counted and named, never fatal."""

import json
import re
from pathlib import Path
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support import handmade, strays
from support.handmade import START_NS
from support.rewriting import raw, unequal, written

from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.doctor import check_recording
from pmwvc_analysis.recording.content import content_of
from pmwvc_analysis.recording.from_traces import record_traces
from pmwvc_analysis.recording.reader import read_session, session_of
from pmwvc_analysis.session_files import finish
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_bringup import scenarios
from pmwvc_core.errors import PmwvcError
from pmwvc_core.simulation.session import simulate_one

LENGTH_S = 0.24
SCENARIO = handmade.scenario(duration_s=LENGTH_S)
SLOW = settings(deadline=None, max_examples=20, suppress_health_check=[HealthCheck.too_slow])


class Own(list):
    """The messages of a session; a failing test does not print them all."""

    def __repr__(self):
        return f"{len(self)} messages"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("own") / "session"
    record_traces(place, handmade.session(duration_s=LENGTH_S), SCENARIO, start_ns=START_NS)
    return place


@pytest.fixture(scope="module")
def own(folder):
    return Own(raw(folder))


@pytest.fixture(scope="module")
def undisturbed(folder):
    return read_session(folder)


def judged(found):
    """Do what report and doctor do with a recording, without file and pictures."""
    ordered = sorted(found, key=lambda each: each.log_ns)
    traces = session_of(content_of(ordered, strays.STORE.deserialize_cdr), Path("none"))
    result = summary(traces, SCENARIO, budget(traces, SCENARIO))
    json.dumps(result, allow_nan=False)
    inconsistencies(traces, SCENARIO)
    return traces, result


def same_motion(found, expected):
    """Assert that the signals, energies and packets that are judged are those of the session."""
    for name in ("users", "server", "packets"):
        assert list(unequal(getattr(found, name), getattr(expected, name))) == []


def strangers(traces):
    return [event for event in traces.events if event.get("kind") == "stranger"]


@pytest.mark.parametrize("topic", ["/server/trace", "/user1/trace"])
def test_messages_of_other_lengths_are_counted_and_left_out(own, undisturbed, topic):
    some = [each for each in own if each.topic == topic][5:22]
    odd = [strays.other_lengths(each, None, 5) for each in some]
    traces, result = judged(own + odd)
    same_motion(traces, undisturbed)
    (event,) = strangers(traces)
    assert re.match(rf"17 messages on {topic} whose fields do not fit", event["what"])
    assert result["passivity"]["text"] == judged(own)[1]["passivity"]["text"]


@pytest.mark.parametrize(
    ("topic", "part"),
    [
        ("/server/trace", slice(10, 27)),
        ("/user1/trace", slice(0, None)),
        ("/user1/wave_up", slice(0, 1)),
    ],
)
def test_a_second_publisher_is_counted_and_left_out(own, undisturbed, topic, part):
    some = [each for each in own if each.topic == topic][part]
    second = [strays.of_stranger(each)._replace(log_ns=each.log_ns + 1000) for each in some]
    traces, _ = judged(own + second)
    same_motion(traces, undisturbed)
    (event,) = strangers(traces)
    assert event["what"].startswith(f"{len(some)} message")
    assert f"on {topic} from another publisher, left out" in event["what"]
    assert traces.counts.items() <= undisturbed.counts.items()


def test_a_publisher_with_packets_of_its_own_is_left_out_where_it_overlaps(own, undisturbed):
    second = [
        strays.of_stranger(each)._replace(log_ns=each.log_ns + 1000)
        for each in own
        if each.topic in ("/user1/trace", "/user1/wave_up") and each.log_ns % 3 == 0
    ]
    traces, _ = judged(own + second)
    same_motion(traces, undisturbed)
    assert {event["who"]: event["what"] for event in strangers(traces)} == {
        topic: f"10 messages on {topic} from another publisher, left out"
        for topic in ("/user1/trace", "/user1/wave_up")
    }


def test_a_message_with_the_sessions_epoch_and_another_number_is_left_out(own, undisturbed):
    step = next(each for each in own if each.topic == "/server/trace")
    odd = [
        strays.with_value(step, "step", 10**9),
        strays.with_value(step, "start_ns", 2**61),
        strays.with_value(strays.with_value(step, "step", 10**4), "start_ns", 2**61),
    ]
    traces, _ = judged(own + odd)
    same_motion(traces, undisturbed)
    assert sum(int(event["what"].split()[0]) for event in strangers(traces)) == 3
    assert traces.counts["/server/trace"]["missing"] == 0


def test_a_node_that_starts_again_is_no_stranger(own):
    """The control: an epoch that follows another in time is the same node, started again."""
    half = sorted({each.log_ns for each in own})[len({each.log_ns for each in own}) // 2]

    def restarted(each):
        if each.topic in ("/user1/trace", "/user1/wave_up") and each.log_ns > half:
            return strays.with_value(each, "epoch", 77)
        return each

    traces, _ = judged([restarted(each) for each in own])
    assert strangers(traces) == []
    assert set(traces.users[0].epoch.tolist()) == {1, 77}


def test_a_server_that_steps_once_a_second_is_no_stranger(tmp_path):
    texts = "server.period_s=1", "link.delay_s=0"
    slow = scenarios.load("carry_16ms", settings_texts=texts, duration_s=4.0)
    record_traces(tmp_path, simulate_one(slow), slow)
    found = finish(tmp_path, figures=False)
    assert (found["strangers"], found["interrupted"], found["recording"]["holes"]) == ([], [], [])
    assert found["passivity"]["passive"] is True


@given(st.integers(0, 2**32))
@SLOW
def test_whatever_comes_between_is_never_fatal(own, seed):
    draw = Random(seed)
    odd = [strays.mutated(draw, own) for _ in range(draw.randrange(1, 12))]
    traces, result = judged(own + odd)
    assert len(traces.users) == len(result["users"]) == 2


@given(st.integers(0, 2**32))
@SLOW
def test_a_recording_in_which_anything_was_changed_is_never_fatal(own, seed):
    draw = Random(seed)
    changed = list(own)
    for _ in range(draw.randrange(1, 30)):
        changed[draw.randrange(len(own))] = strays.mutated(draw, own)
    if seed % 2:
        times = [each.log_ns for each in changed]
        draw.shuffle(times)
        changed = [e._replace(log_ns=log_ns) for e, log_ns in zip(changed, times, strict=True)]
    try:
        judged(changed)
    except PmwvcError as error:
        assert str(error)


def test_the_report_of_a_disturbed_recording_is_written(own, folder, tmp_path):
    odd = [strays.other_lengths(each, None, 3) for each in own[:200:3]]
    odd += [each._replace(data=each.data[:50]) for each in own[:200:7]]
    place = written(sorted(own + odd, key=lambda each: each.log_ns), tmp_path / "stray")
    (place / "scenario.yaml").write_bytes((folder / "scenario.yaml").read_bytes())
    assert finish(place)["passivity"]["text"] == judged(own)[1]["passivity"]["text"]
    assert any("do not fit together" in finding.text for finding in check_recording(place))
    assert "do not fit together" in (place / "report.html").read_text("utf-8")
