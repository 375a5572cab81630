# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A nonlinear scenario is refused by name; the nearest linear scenario is one that is answered."""

import pytest
from support import linear_loops
from support import plain as files

from pmwvc_analysis.models.linear import NonlinearError, nonlinear, relative
from pmwvc_analysis.models.linearize import build

SECANT = {"server__coupling": "unknown", "server__environment": "wall"}
BLACK_BOX = SECANT | {"server__decoding": "late"}
REFUSED = [
    ({"server__compensation": "printed"} | BLACK_BOX, "server.compensation=none"),
    ({"server__compensation": "corrected"} | BLACK_BOX, "server.compensation=none"),
    ({"server__compensation": "ledger"} | BLACK_BOX, "server.compensation=none"),
    (BLACK_BOX | {"server__environment": "hunt_crossley"}, "server.environment=wall"),
    (BLACK_BOX | {"server__environment": "active_wall"}, "server.environment=wall"),
    (SECANT, "server.environment=wall_with_slope"),
    (SECANT | {"server__environment": "cube"}, "server.decoding=late"),
    (SECANT | {"server__environment": "hunt_crossley"}, "server.environment=wall_with_slope"),
    ({"master__position__gain": 10.0}, "master.position.feedback=printed"),
    (
        {"master__position__gain": 10.0, "master__position__feedback": "integral"},
        "master.position.feedback=printed",
    ),
    ({"controller": "pspm"}, "controller=virtual_coupling"),
    ({"device__friction": 0.1}, "device.friction=0"),
    ({"device__encoder_step_m": 1e-5}, "device.encoder_step_m=0"),
    ({"link__up__rate_limit_bps": 1e5}, "link.up.rate_limit_bps=0"),
]


@pytest.mark.parametrize(("values", "instead"), REFUSED)
def test_it_is_refused_by_name_and_has_a_linear_relative(values, instead):
    scenario = linear_loops.scenario(**values)
    with pytest.raises(NonlinearError) as error:
        build(scenario)
    assert f"--set {instead}" in str(error.value)
    for element in nonlinear(scenario):
        assert element.text in str(error.value)
    near = relative(scenario)
    assert instead in near.settings
    assert nonlinear(near.scenario) == []
    assert build(near.scenario).states


def test_dissipation_that_is_counted_has_no_linear_relative():
    scenario = linear_loops.scenario(controller="tdpa")
    assert relative(scenario) is None
    with pytest.raises(NonlinearError, match="controller = tdpa: has no linear model, and none"):
        build(scenario)


@pytest.mark.parametrize("name", files.known())
def test_every_scenario_is_linear_or_has_a_linear_relative(name):
    scenario = files.load(name)
    near = relative(scenario)
    if scenario.environment.linear is None:  # a scene
        assert near is None and nonlinear(scenario)
    else:
        assert nonlinear(near.scenario if near else scenario) == []
