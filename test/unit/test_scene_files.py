# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scene files that cannot be used, each refused with a way out."""

from pathlib import Path

import pytest
from support.scenes import scene, written

from pmwvc_core.errors import ParameterError


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"scene": ""}, "server.scene is empty: name the scene's MJCF file (.xml)"),
        ({"scene": "nowhere.xml"}, "server.scene = 'nowhere.xml': there is no such file"),
        ({"handles": "bix, box"}, "no body is named 'bix'; did you mean"),
        ({"handles": "box"}, "server.handles = 'box': 1 bodies for 2 users"),
        ({"handles": "box, box"}, "must be a child of worldbody without joints"),
    ],
)
def test_a_scene_that_cannot_be_used_is_refused_with_a_way_out(tmp_path, values, words):
    given_values = {"scene": written(tmp_path), **values}
    with pytest.raises(ParameterError) as caught:
        scene(given_values.pop("scene"), **given_values)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<body", "<bady", "Line number=3"),
        ('name="table"', 'name="table" material="oak"', "oak"),
        ("-0.0401", "-0.03", "'table' and 'box' overlap"),
        ("<option", '<option timestep="0.05"', "its timestep of 0.05 s is longer than"),
        ('name="box"', 'name="pmwvc_user1"', "cannot be used: ValueError: Error: repeated name"),
        ('mass="0.2"', 'mass="20000"', "'box' has 1e+05 times the mass of 'pea'"),
    ],
)
def test_a_scene_file_that_is_wrong_is_refused_with_a_way_out(tmp_path, old, new, words):
    file = Path(written(tmp_path))
    pea = '<body name="pea" pos="0 0 1"><freejoint/><geom size="0.01" mass="0.2"/></body>'
    text = file.read_text("utf-8").replace("</worldbody>", f"{pea}</worldbody>")
    file.write_text(text.replace(old, new, 1), "utf-8")
    with pytest.raises(ParameterError) as caught:
        scene(file)
    assert words in str(caught.value)
