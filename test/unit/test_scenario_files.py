# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The scenarios that come with the project, and how scenario files are found and read."""

from dataclasses import replace

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


@pytest.fixture
def written(tmp_path):
    def write(text, name="mine.yaml"):
        path = tmp_path / name
        path.write_text(text, "utf-8")
        return path

    return write


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_is_short_states_what_happens_and_is_its_printed_form(name):
    text, scenario = scenarios.known()[name].read_text("utf-8"), scenarios.load(name)
    assert "hat to see: " in text
    assert len(text.splitlines()) <= 45
    assert max(map(len, text.splitlines())) <= 110
    assert scenario.name == name
    assert scenario.description.endswith(".")
    takes_part = any(user.operator.is_remote for user in scenario.users)
    assert 2.0 <= scenario.duration_s <= (600.0 if takes_part else 20.0)
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


@pytest.mark.parametrize(
    ("name", "other", "expected"),
    [
        ("carry_16ms", "direct_16ms", {"controller"}),
        ("carry_24ms", "stiff_24ms", {"server.contact_stiffness"}),
    ],
)
def test_scenarios_of_one_task_differ_only_in_what_their_names_give(name, other, expected):
    one, two = scenarios.load(name).flat(), scenarios.load(other).flat()
    assert {key for key in one if one[key] != two[key]} == {"name", "description", *expected}


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


@pytest.mark.parametrize("name", ["lan", "lte", "geo"])
def test_a_network_by_name_has_every_setting_of_its_preset(name):
    preset = PRESETS[name]
    assert links_of(f"link.preset={name}") == [(preset.up, preset.down)] * 2


def test_a_network_by_name_holds_where_it_is_set_and_settings_beside_it_win(written):
    lte, geo = PRESETS["lte"], PRESETS["geo"]
    two = links_of("link.preset=lte", "user2.link.down.preset=geo")
    assert two == [(lte.up, lte.down), (lte.up, geo.down)]
    wanted = replace(lte.up, loss=0.2)
    assert links_of("link.loss=0.2", "link.preset=lte")[0][0] == wanted
    assert links_of("link.preset=lte", "link.loss=0.2")[0][0] == wanted
    path = written(MINIMAL + "link: {loss: 0.2, preset: lte, delay_s: 0.5}\n")
    user = scenarios.load(str(path)).users[1]
    assert user.link_up == replace(wanted, delay_s=0.5)
    user = scenarios.load(str(path), settings_texts=["link.preset=lan"]).users[0]
    assert user.link_up == PRESETS["lan"].up  # the command line replaces the file's


def masters_of(*settings):
    texts = ["channel=strict", *settings]
    masters = [user.master for user in scenarios.load("carry_0ms", settings_texts=texts).users]
    return [
        (each.impedance, each.contact_impedance, each.position.adapts, each.position.storage_j)
        for each in masters
    ]


def test_impedances_by_name_hold_for_all_or_one_and_settings_beside_them_win():
    light, even = (8.0, 12.0, True, 0.005), (25.0, None, False, 0.0)
    assert masters_of("master.preset=light") == [light] * 2
    assert masters_of("user2.master.preset=light") == [even, light]
    assert masters_of("master.impedance=10", "master.preset=light")[0] == (10.0, *light[1:])
    assert masters_of() == masters_of("master.preset=even") == [even] * 2
    refusal = refused("carry_0ms", settings_texts=["master.preset=firm", "channel=plain"])
    assert "user1.master.contact_impedance = 25: needs channel = strict" in refusal
    (refusal,) = refused("carry_0ms", settings_texts=["master.preset=lite"])
    assert refusal.endswith("must be one of even, light, firm; did you mean light?")


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
        (MINIMAL + "task: lift\n", "a group has no value of its own; did you mean task.kind?"),
        (MINIMAL + "server: {scene: box.xml}\n", "set server.environment = mujoco"),
        (MINIMAL + "link: {delay_s: 1, delay_s: 2}\n", "is not YAML in line 5"),
        ("a: !!python/object/apply:os.system ['true']\n", "is not YAML"),
        (MINIMAL + "link: {preset: transatlantik}\n", "did you mean transatlantic?"),
    ],
)
def test_a_file_that_is_no_scenario_is_refused_with_its_place(written, text, message):
    (problem,) = refused(written(text))
    assert message in problem


def test_what_is_not_there_or_cannot_be_read_is_refused(tmp_path):
    path = tmp_path / "bytes.yaml"
    path.write_bytes(b"name: \xff\xfe")
    assert "cannot be read" in refused(path)[0]
    assert refused(tmp_path / "nothing.yaml") == ["there is no such file"]
    assert refused(tmp_path / "nothing") == ["there is no such session folder or scenario file"]


def test_anchors_and_merges_of_yaml_work(written):
    text = MINIMAL + "link: {up: &one {delay_s: 0.01}, down: {<<: *one, loss: 0.5}}\n"
    user = scenarios.load(str(written(text))).users[0]
    assert (user.link_down.delay_s, user.link_down.loss) == (0.01, 0.5)


@pytest.mark.parametrize("in_file", [True, False])
def test_files_are_named_from_where_they_are_written(written, tmp_path, monkeypatch, in_file):
    written("t,x\n", "motion.csv")
    operator = "operator: {kind: playback_motion, file: motion.csv}\n"
    path = written(MINIMAL + operator * in_file)
    monkeypatch.chdir("/" if in_file else tmp_path)
    options = [] if in_file else ["operator.file=motion.csv"]
    scenario = scenarios.load(str(path), settings_texts=options)
    assert scenario.users[0].operator.file == str(tmp_path / "motion.csv")


@given(st.lists(st.text(max_size=30), max_size=3))
def test_any_text_for_set_is_taken_or_refused_never_a_crash(texts):
    try:
        scenarios.load("carry_0ms", settings_texts=texts)
    except ScenarioError as error:
        assert error.problems
