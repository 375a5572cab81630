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
from pmwvc_core.errors import ParameterError, PmwvcError, ScenarioError
from pmwvc_core.scenario.reader import parse_scenario


@pytest.fixture(scope="module")
def pmwvc(tmp_path_factory):
    """The command line beside an installed package: the example of the documentation."""
    with example_of(tmp_path_factory.mktemp("lab"), "controllers.md") as run:
        yield run


FOUR = ("--set", "controller=four_channel")


def test_a_controller_of_another_package_is_simulated_judged_and_reported(pmwvc, tmp_path):
    out = tmp_path / "one"
    words = ["carry_0ms", *FOUR, "--set", "user2.four_channel.forward=0.3", "--duration", "2"]
    result = pmwvc("simulate", *words, "--out", out, "--no-figures")
    assert result.returncode == 0, result.stderr
    assert "Four channels: positions, velocities and forces both ways" in result.stdout
    assert "  Stable: spectral radius" in result.stdout
    assert "four_channel comes from another package: its model is that of" in result.stdout
    assert "Predicted stable: it was." in result.stdout
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    assert summary["controller"] == "four_channel"
    assert summary["parameters"]["user1.four_channel.forward"] == 0.5
    assert summary["parameters"]["user2.four_channel.forward"] == 0.3
    assert summary["prediction"]["any_delay"] is None
    changed = ("--set", "four_channel.forward=0.1", "--out", tmp_path / "again")
    again = pmwvc("replay", out, *changed, "--no-figures")
    assert again.returncode == 0, again.stderr
    summary = json.loads((tmp_path / "again" / "summary.json").read_text("utf-8"))
    assert summary["parameters"]["four_channel.forward"] == 0.1


def test_wrong_parameters_of_a_plug_in_are_refused_like_those_of_the_library(pmwvc):
    for setting, text in (
        ("four_channel.forward=2", "four_channel.forward = 2.0: must be 0..1"),
        ("four_channel.fordward=0.2", "did you mean four_channel.forward?"),
    ):
        result = pmwvc("simulate", "carry_0ms", *FOUR, "--set", setting)
        assert result.returncode != 0
        assert text in result.stderr


SOFT = dataclasses.replace(library.LIBRARY["pmwvc"], name="soft", words="Damped waves.")


@pytest.fixture
def lab(monkeypatch):
    """A laboratory's own module with records, good and bad."""
    records = {
        "alone": dataclasses.replace(SOFT, name="alone", linear=None),
        "near": dataclasses.replace(SOFT, name="near", linear="pmwvc"),
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


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("absent", r"lab_vendor_library:RECORD\) cannot be imported: ModuleNotFoundError"),
        ("stone", r"is not a controller: it is a object, must be a record"),
        ("other", r"has another name: 'soft'"),
        ("stray", r"linear = 'moon': must be None or one of stray, pmwvc, direct"),
    ],
)
def test_a_broken_plug_in_is_refused_with_the_reason(lab, name, text):
    values = {"name": "one", "controller": name, "channel": "plain", "users": 1, "duration_s": 0.2}
    with pytest.raises(ScenarioError, match=rf"controller = '{name}'.*{text}"):
        parse_scenario(values)


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


def test_a_record_refuses_properties_that_contradict_one_another():
    direct = library.LIBRARY["direct"]
    with pytest.raises(ParameterError, match=r"coupling = None: .*belongs to waves"):
        dataclasses.replace(direct, coupling=None)
    with pytest.raises(ParameterError, match=r"avatar = None: .*needs both laws"):
        dataclasses.replace(direct, device=lambda s, tick, p: (s, None))
