# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Safety limits while a hand is on the device: stricter, never wider."""

import dataclasses

import pytest
from support.parameter_nodes import change
from support.peers import ros

from pmwvc_core.errors import ParameterError
from pmwvc_core.master.safety import check_change
from pmwvc_core.params import SafetyParams, specs
from pmwvc_master.settings import declare_settings

NOW = SafetyParams()
STRICTER = {
    "max_force": 4.0,
    "max_slew": 500.0,
    "damper_velocity": 0.5,
    "fault_velocity": 1.2,
    "timeout_s": 0.02,
    "release_s": 0.5,
}


@pytest.mark.parametrize("name", STRICTER)
def test_a_limit_becomes_stricter_and_never_wider(name):
    stricter = dataclasses.replace(NOW, **{name: STRICTER[name]})
    check_change(NOW, stricter)
    unit = specs(SafetyParams)[name].unit
    with pytest.raises(ParameterError, match=f"safety.{name} = .*while running .*now .* {unit}"):
        check_change(stricter, NOW)


def test_every_limit_can_only_be_lowered_but_soft_start_and_torque_which_stay():
    fixed = {name for name, spec in specs(SafetyParams).items() if spec.read_only}
    assert fixed == {"soft_start_s", "max_torque"}
    assert {*STRICTER, *fixed} == set(specs(SafetyParams))


def test_the_force_can_always_be_let_go():
    with pytest.raises(ParameterError, match=r"max_slew = 1: must be >= 16 N/s"):
        check_change(NOW, dataclasses.replace(NOW, max_slew=1.0))
    check_change(NOW, dataclasses.replace(NOW, max_slew=16.0))


def test_a_running_master_refuses_to_widen_its_limits():
    with ros(automatically_declare_parameters_from_overrides=True) as peer:
        taken = []
        declare_settings(peer.node, lambda _: None, taken.append)

        def refusal(**values):
            return change(peer.node, **{f"safety.{n}": v for n, v in values.items()})

        assert refusal(max_force=20.0) == (
            "safety.max_force = 20: can only be lowered while running (now 8 N); "
            "restart the master with another value"
        )
        assert "can only be lowered" in refusal(max_force=4.0, max_slew=20000.0)
        assert "read-only" in refusal(soft_start_s=10.0)  # nobody hurries it or holds it up
        assert taken == []
        assert refusal(max_force=4.0) == ""
        assert "now 4 N" in refusal(max_force=8.0)
        assert taken == [SafetyParams(max_force=4.0)]
