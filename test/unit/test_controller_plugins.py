# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers by name: the library, and one of another package through the whole program."""

import dataclasses
import json

import pytest
from support.lab import example_of, offer
from support.plain import load

from pmwvc_analysis.models.answer import answer
from pmwvc_analysis.models.linear import NonlinearError
from pmwvc_analysis.prediction import text as prediction_text
from pmwvc_analysis.tune.search import propose
from pmwvc_core import plugins
from pmwvc_core.controllers import library
from pmwvc_core.controllers.library import CHANNELS
from pmwvc_core.errors import ParameterError, PmwvcError, ScenarioError
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.session import simulate_one


@pytest.fixture(scope="module")
def pmwvc(tmp_path_factory):
    """The command line beside an installed package: the example of the documentation."""
    return example_of(tmp_path_factory.mktemp("lab"), "controllers.md")


def test_a_controller_of_another_package_is_simulated_judged_and_reported(pmwvc, tmp_path):
    out = tmp_path / "one"
    words = ["carry_16ms", "--set", "controller=soft", "--duration", "4", "--out", out]
    result = pmwvc("simulate", *words)
    assert result.returncode == 0, result.stderr
    assert "The mean of the last two waves is taken" in result.stdout
    assert "  Stable: spectral radius" in result.stdout
    assert "soft comes from another package: its model was tried" in result.stdout
    assert "Predicted stable: it was." in result.stdout
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    assert summary["controller"] == "soft"
    assert summary["stable"] is True
    assert summary["prediction"]["any_delay"] is None  # the proof is not one of this controller
    assert pmwvc("report", out).returncode == 0
    text = (out / "report.html").read_text("utf-8")
    assert "The mean of the last two waves is taken" in text
    assert "the link acts like" not in text


def test_a_controller_of_another_package_is_compared(pmwvc, tmp_path):
    over = ["--controllers", "pmwvc,soft", "--duration", "4", "--json", "--no-figures"]
    result = pmwvc("compare", "carry_16ms", *over, "--out", tmp_path / "all")
    assert result.returncode == 0, result.stderr
    waves, soft = json.loads(result.stdout)["sessions"]
    assert soft["settings"] == {"controller": "soft"}
    assert soft["k_felt"] < 0.99 * waves["k_felt"]  # half a frame more lag is rendered


def test_a_controller_of_another_package_has_an_exact_model(pmwvc):
    found = {}
    for controller in ("soft", "pmwvc"):
        settings = ("--set", f"controller={controller}", "--set", "channel=plain", "--json")
        result = pmwvc("stability", "carry_16ms", *settings)
        assert result.returncode == 0, result.stderr
        found[controller] = json.loads(result.stdout)
    soft, waves = found["soft"], found["pmwvc"]
    assert soft["stable"] is True
    assert soft["states"] == waves["states"] + 2  # the wave before, of two users
    assert soft["spectral_radius"] > waves["spectral_radius"]
    [note] = [note for note in soft["notes"] if "another package" in note]
    assert "controller = soft" in note
    assert "signals of up to 8 mm" in note


def test_a_controller_of_another_package_is_tuned_by_its_own_model(pmwvc):
    settings = ("--set", "controller=soft", "--set", "channel=plain", "--json")
    result = pmwvc("tune", "wall", *settings)
    assert result.returncode == 0, result.stderr
    found = json.loads(result.stdout)
    assert found["best"]["stable"] is True
    assert found["best"]["lag_s"] is None  # not known of code from another package


SOFT = dataclasses.replace(library.LIBRARY["pmwvc"], name="soft", words="Damped waves.")


@pytest.fixture
def lab(monkeypatch):
    """A laboratory's own module with records, good and bad."""
    records = {
        "alone": dataclasses.replace(SOFT, name="alone", linear=None),
        "near": dataclasses.replace(SOFT, name="near", linear="pmwvc"),
        "portless": dataclasses.replace(SOFT, name="portless", make_black_box=None),
        "other": SOFT,
        "stray": dataclasses.replace(SOFT, name="stray", linear="moon"),
        "stone": object(),
        "pmwvc": SOFT,
    }
    group, absent = library.RECORDS.plugins.group, "lab_vendor_library:RECORD"
    offer(monkeypatch, group, "lab_controllers", records, absent=absent)
    plugins.imported.cache_clear()
    yield
    plugins.imported.cache_clear()


def scenario(controller, *, channel="plain", **server):
    values = {"name": "one", "controller": controller, "users": 1, "duration_s": 0.2}
    return parse_scenario(values | {"channel": channel, "server": server})


def test_the_library_goes_before_a_plug_in_of_the_same_name(lab):
    assert library.record_of("pmwvc") is library.LIBRARY["pmwvc"]
    assert library.names().count("pmwvc") == 1


@pytest.mark.parametrize("channel", CHANNELS)
@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("absent", r"lab_vendor_library:RECORD\) cannot be imported: ModuleNotFoundError"),
        ("stone", r"is not a controller: it is a object, must be a record"),
        ("other", r"has another name: 'soft'"),
        ("stray", r"linear = 'moon': must be None or one of stray, pmwvc, direct"),
    ],
)
def test_a_broken_plug_in_is_refused_with_the_reason(lab, name, text, channel):
    with pytest.raises(ScenarioError, match=rf"controller = '{name}'.*{text}"):
        scenario(name, channel=channel)


def test_an_unknown_name_is_answered_with_what_is_there(lab):
    with pytest.raises(ScenarioError, match=r"'moon': must be one of pmwvc, .*pspm.*portless"):
        scenario("moon")
    with pytest.raises(ParameterError, match=r"'moon': must be one of.*'pmwvc\.controllers'"):
        library.record_of("moon")


def test_a_controller_without_a_linear_relative_is_predicted_in_words_only(lab):
    alone = load("carry_16ms", settings_texts=["controller=alone"])
    first, *_, last = prediction_text.lines(alone, live=False)
    assert first == "No exact model, not linear: controller = alone. No linear scenario is near."
    assert last == "Damped waves."
    with pytest.raises(NonlinearError, match="controller = alone: has no linear model"):
        answer(alone)


def test_a_controller_near_one_of_the_library_is_answered_with_that(lab):
    near = load("carry_16ms", settings_texts=["controller=near"])
    with pytest.raises(NonlinearError, match=r"controller = near; ask .* --set controller=pmwvc"):
        answer(near)
    with pytest.raises(PmwvcError, match="near: has no exact model to tune it by"):
        propose(near)


def test_a_controller_without_a_port_for_black_boxes_is_refused_there(lab):
    simulate_one(scenario("portless"))
    with pytest.raises(ParameterError, match="controller = portless has no port for it"):
        simulate_one(scenario("portless", coupling="unknown", environment="wall"))


def test_a_record_refuses_properties_that_contradict_one_another():
    direct = library.LIBRARY["direct"]
    with pytest.raises(ParameterError, match=r"coupling = None: .*belongs to waves"):
        dataclasses.replace(direct, coupling=None)
    with pytest.raises(ParameterError, match=r"object_motion = 'flying': must be one of"):
        dataclasses.replace(direct.coupling, object_motion="flying")
    rule = library.LIBRARY["tdpa"].rule
    with pytest.raises(ParameterError, match=r"group = 'mine': BaselineParams has no such group"):
        dataclasses.replace(rule, group="mine")
