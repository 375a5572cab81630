# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What ``pmwvc stability`` and ``pmwvc map`` print, write and refuse."""

import functools
import json

import pytest
from support.command_line import here, refused

PLAIN = ("--set", "channel=plain")
FIRST_ORDER = (*PLAIN, "--set", "master.filter.kind=first_order")
LATE = ("--set", "server.coupling=one_frame_late", "--set", "master.hold=zoh", *FIRST_ORDER)


@pytest.fixture
def pmwvc(tmp_path):
    return functools.partial(here, cwd=tmp_path)


def test_stability_answers_with_documented_keys(pmwvc):
    result = pmwvc("stability", "carry_16ms", *LATE, "--json")
    found = json.loads(result.stdout)
    assert found["k_max"] == pytest.approx(2166.0, rel=5e-3)
    assert found["stable"] is True and found["spectral_radius"] < 1.0
    assert found["k_max_bound"] == 1e6
    assert found["rigid_body_modes"] == 4
    assert found["hyperframe_ticks"] == 8
    assert found["states"] == 20
    assert any("Grip" in note for note in found["notes"])


def test_stability_without_a_limit_is_null_in_json_and_stated_in_words(pmwvc):
    words = ("stability", "carry_16ms", *FIRST_ORDER)
    assert json.loads(pmwvc(*words, "--json").stdout)["k_max"] is None
    assert "stable at every contact stiffness up to 1,000,000 N/m" in pmwvc(*words).stdout


def test_the_z_width_is_that_of_each_damping_and_only_of_a_linear_scenario(pmwvc):
    wall = ("stability", "wall_slow", "--set", "server.decoding=late", "--json")
    plain = (*wall, "--set", "server.compensation=none")
    alone = pmwvc(*plain, "--set", "server.contact_damping=5")
    found = pmwvc(*plain, "--damping", "5,20")
    less, more = json.loads(found.stdout)["z_width"]
    assert less["k_max"] == json.loads(alone.stdout)["k_max"] > 0.0
    assert more["k_max"] != less["k_max"]
    assert "is not linear" in refused(pmwvc(*wall, "--damping", "5"))


DELAYS = "link.delay_s=0:0.01:2"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("stability", "carry_16ns"), "did you mean carry_16ms"),
        (("stability", "carry_16ms", "--set", "device.friction=0.1"), "use 'pmwvc simulate'"),
        (("stability", "carry_16ms", "--set", "device.encoder_step_m=1e-5"), "is not linear"),
        (("stability", "carry_16ms", "--bound", "-3"), "--bound"),
        (
            ("stability", "carry_16ms", "--set", "user1.master.rate_drop=997",
             "--set", "user2.master.rate_drop=991"),
            "common factors",
        ),
        (
            ("map", "wall", "--x", "device.mas=1:2:3", "--y", "link.delay_s"),
            "--x: device.mas: there is no such parameter; did you mean",
        ),
        (("map", "wall", "--x", "device.mass=2:1:3", "--y", "link.delay_s"), "FIRST:LAST:COUNT"),
        (("map", "wall", "--x", DELAYS, "--y", DELAYS), "two different"),
        (("map", "wall", "--x", "server.coupling", "--y", "link.delay_s"), "FIRST:LAST:COUNT"),
    ],
)  # fmt: skip
def test_a_mistake_is_reported_once_and_clearly(pmwvc, words, said):
    assert said in refused(pmwvc(*words))


def test_a_map_is_written_in_a_folder_of_its_own(pmwvc, tmp_path):
    words = (
        "map", "carry_16ms", *LATE, "--x", "server.contact_stiffness=2000:2600:13",
        "--y", "link.delay_s=0.008:0.016:2", "--json",
    )  # fmt: skip
    found = json.loads(pmwvc(*words, "--out", "drawn").stdout)
    assert found["boundary"] == pytest.approx([2470.8, 2166.0], rel=5e-3)
    kinds = {path.suffix for path in (tmp_path / "drawn").glob("map.*")}
    assert kinds == {".png", ".svg", ".csv", ".json"}
    assert "drawn is not empty" in refused(pmwvc(*words, "--out", "drawn"))
    assert pmwvc(*words).returncode == 0
    (folder,) = (tmp_path / "sessions").iterdir()
    assert folder.name.endswith("-carry_16ms-map")


def test_what_decides_a_scenario_is_no_axis_of_a_map(pmwvc):
    message = refused(pmwvc("map", "wall", "--x", "dof=1:2:2", "--y", "link.delay_s"))
    assert "wall: dof: decides what a scenario is" in message
