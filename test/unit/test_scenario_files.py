# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The scenarios that come with the project, and how scenario files are found and read."""

import os
from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_bringup import scenarios
from pmwvc_core.errors import ScenarioError
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.scenario.reader import parse_scenario

NAMES = list(scenarios.known())
MINIMAL = "name: mine\nduration_s: 1.0\ncontroller: pmwvc\nusers: 2\n"


def refused(name, **options):
    with pytest.raises(ScenarioError) as caught:
        scenarios.load(str(name), **options)
    return caught.value.problems


def hand_motion():
    """The recording of the scenario ``playback``, from the formula in its file."""

    def s(r):
        r = np.clip(r, 0.0, 1.0)
        return 10 * r**3 - 15 * r**4 + 6 * r**5

    time_s = np.arange(600) / 50.0
    grip = s((time_s - 0.5) / 1.5) * (1.0 - s((time_s - 10.5) / 1.0))
    moving = (time_s >= 3.0) & (time_s < 9.0)
    carry = np.where(moving, 0.01 * (1.0 - np.cos(2 * np.pi * (time_s - 3.0) / 3.0)), 0.0)
    left, right = (0.00005 * np.sin(2 * np.pi * hz * time_s) for hz in (8.5, 7.9))
    columns = time_s, carry + grip * (0.008 + left), carry + grip * (-0.008 + right)
    rows = (f"{t:.2f},{a:.6f},{b:.6f}" for t, a, b in zip(*columns, strict=True))
    return "\n".join(["time_s,left_m,right_m", *rows]) + "\n"


@pytest.fixture
def written(tmp_path):
    def write(text, name="mine.yaml"):
        path = tmp_path / name
        path.write_text(text, "utf-8")
        return path

    return write


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_has_the_name_of_its_file_and_states_what_happens(name):
    scenario = scenarios.load(name)
    assert scenario.name == name
    assert scenario.description.endswith(".")
    takes_part = any(user.operator.from_outside for user in scenario.users)
    longest_s = 600.0 if takes_part else 20.0
    assert 2.0 <= scenario.duration_s <= longest_s


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_file_is_short_and_states_what_one_should_see(name):
    text = scenarios.known()[name].read_text("utf-8")
    assert "hat to see: " in text
    assert len(text.splitlines()) <= 45
    assert max(map(len, text.splitlines())) <= 110


@pytest.mark.parametrize("name", NAMES)
def test_the_printed_form_of_a_scenario_is_the_scenario(name):
    scenario = scenarios.load(name)
    assert parse_scenario(yaml.safe_load(scenarios.to_yaml(scenario))) == scenario


def test_thesis_scenarios_have_the_numbers_of_the_thesis():
    for delay_ms in (0, 16, 24):
        scenario = scenarios.load(f"thesis_controlled_{delay_ms}ms")
        assert scenario.server.coupling == "one_step_delay"
        assert scenario.server.integrator == "backward_euler"
        assert (scenario.server.object_mass, scenario.server.object_damping) == (2.0, 0.0)
        for user, force in zip(scenario.users, (1.0, -1.0), strict=True):
            assert (user.master.impedance, user.master.frame_s) == (25.0, 0.008)
            assert (user.master.filter.pole_rad_s, user.master.hold) == (50.0, "foh")
            assert (user.contact.contact_stiffness, user.contact.contact_damping) == (500.0, 10.0)
            assert (user.device.mass, user.device.damping) == (0.25, 0.0)
            assert (user.operator.kind, user.operator.force) == ("constant", force)
            assert user.link_up.delay_s == user.link_down.delay_s == delay_ms / 1000


def test_scenarios_of_one_task_differ_only_in_what_their_names_give():
    calm, direct = scenarios.load("carry_16ms").flat(), scenarios.load("direct_16ms").flat()
    different = {name for name in calm if calm[name] != direct[name]}
    assert different == {"name", "description", "controller"}
    calm, stiff = scenarios.load("carry_24ms").flat(), scenarios.load("stiff_24ms").flat()
    different = {name for name in calm if calm[name] != stiff[name]}
    assert different == {"name", "description", "server.contact_stiffness"}


def test_the_recording_is_what_its_formula_gives():
    path = scenarios.known()["playback"].with_name("hand_motion.csv")
    assert path.read_text("utf-8") == hand_motion()


def test_a_wrong_name_gets_the_nearest_right_one():
    assert "did you mean carry_16ms?" in refused("cary_16ms")[0]


def test_a_file_that_is_not_there_is_reported(tmp_path):
    assert refused(tmp_path / "nothing.yaml") == ["there is no such file"]
    assert refused(tmp_path / "nothing") == ["there is no such session folder or scenario file"]


def test_options_win_over_the_file(written):
    scenario = scenarios.load(
        str(written(MINIMAL + "master: {impedance: 10}\n")),
        settings_texts=["master.impedance=1e1", "user2.link.up.loss=0.5", "device.mass = 1"],
        users=3,
        duration_s=2.5,
    )
    assert (len(scenario.users), scenario.duration_s) == (3, 2.5)
    assert [user.link_up.loss for user in scenario.users] == [0.0, 0.5, 0.0]
    assert scenario.users[0].device.mass == 1.0


def links_of(*settings):
    return [
        (user.link_up, user.link_down)
        for user in scenarios.load("carry_0ms", settings_texts=settings).users
    ]


@pytest.mark.parametrize("name", PRESETS)
def test_a_network_by_name_has_every_setting_of_its_preset(name):
    preset = PRESETS[name]
    assert links_of(f"link.preset={name}") == [(preset.up, preset.down)] * 2


def test_a_network_by_name_holds_for_one_user_or_one_direction():
    lte, geo = PRESETS["lte"], PRESETS["geo"]
    assert links_of("link.preset=lte", "user2.link.down.preset=geo") == [
        (lte.up, lte.down),
        (lte.up, geo.down),
    ]


def test_settings_beside_a_network_by_name_win_in_any_order(written):
    wanted = replace(PRESETS["lte"].up, loss=0.2)
    assert links_of("link.loss=0.2", "link.preset=lte")[0][0] == wanted
    assert links_of("link.preset=lte", "link.loss=0.2")[0][0] == wanted
    path = written(MINIMAL + "link: {loss: 0.2, preset: lte}\n")
    assert scenarios.load(str(path)).users[1].link_up == wanted


def test_a_network_of_the_command_line_replaces_the_links_of_the_file(written):
    path = written(MINIMAL + "link: {delay_s: 0.5, duplicate: 0.5}\n")
    user = scenarios.load(str(path), settings_texts=["link.preset=lan"]).users[0]
    assert user.link_up == PRESETS["lan"].up


def test_an_unknown_network_gets_the_nearest_known_one():
    (problem,) = refused("carry_0ms", settings_texts=["link.preset=transatlantik"])
    assert "must be one of ideal, lan" in problem
    assert "did you mean transatlantic?" in problem


def test_mistakes_of_file_and_options_are_reported_together(written):
    path = written(MINIMAL + "mastre: {impedance: 10}\ndof: 9\n")
    found = refused(path, settings_texts=["link.delay_s=-1", "loss", "x=[1"], users=12)
    text = "\n".join(found)
    for part in ("mastre.impedance", "dof = 9", "link.delay_s", "--set loss", "--set x", "12"):
        assert part in text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "holds nothing"),
        ("- 1\n", "holds list"),
        ("a: [1\n", "is not YAML in line 2"),
        (MINIMAL + "users: 3\n", "users is given twice"),
        (MINIMAL + "link: {delay_s: 1, delay_s: 2}\n", "is not YAML in line 5"),
        ("a: !!python/object/apply:os.system ['true']\n", "is not YAML"),
    ],
)
def test_a_file_that_is_no_scenario_is_refused_with_its_place(written, text, message):
    (problem,) = refused(written(text))
    assert message in problem


def test_an_unreadable_file_is_refused(tmp_path):
    path = tmp_path / "bytes.yaml"
    path.write_bytes(b"name: \xff\xfe")
    assert "cannot be read" in refused(path)[0]


def test_anchors_and_merges_of_yaml_work(written):
    text = MINIMAL + "link: {up: &one {delay_s: 0.01}, down: {<<: *one, loss: 0.5}}\n"
    user = scenarios.load(str(written(text))).users[0]
    assert (user.link_down.delay_s, user.link_down.loss) == (0.01, 0.5)


def test_files_are_named_from_where_the_scenario_is(written, tmp_path, monkeypatch):
    written("t,x\n", "motion.csv")
    operator = "operator: {kind: playback_motion, file: motion.csv}\n"
    path = written(MINIMAL + operator)
    monkeypatch.chdir("/")
    assert scenarios.load(str(path)).users[0].operator.file == str(tmp_path / "motion.csv")


def test_files_of_options_are_named_from_the_working_folder(written, tmp_path, monkeypatch):
    written("t,x\n", "motion.csv")
    monkeypatch.chdir(tmp_path)
    scenario = scenarios.load("carry_0ms", settings_texts=["operator.file=motion.csv"])
    assert scenario.users[0].operator.file == os.path.join(tmp_path, "motion.csv")


@given(st.lists(st.text(max_size=30), max_size=3))
def test_any_text_for_set_is_taken_or_refused_never_a_crash(texts):
    try:
        scenarios.load("carry_0ms", settings_texts=texts)
    except ScenarioError as error:
        assert error.problems
