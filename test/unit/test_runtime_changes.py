# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of a running node: what may change, and what refuses a change."""

import dataclasses

import pytest
from support.parameter_nodes import bind, change
from support.peers import ros

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import ContactParams, FilterParams, MasterParams, SafetyParams
from pmwvc_core.runtime.parameter_values import built, values_of


def test_a_change_hands_over_the_complete_new_object():
    with ros() as peer:
        defaults = MasterParams(filter=FilterParams(kind="first_order"))
        start, changes = bind(peer.node, "master", MasterParams, defaults=defaults)
        assert change(peer.node, master__impedance=12) == ""
        assert change(peer.node, master__deadband__ratio=0.2, master__position__gain=5) == ""
        assert changes == [
            dataclasses.replace(start, impedance=12.0),
            dataclasses.replace(
                start,
                impedance=12.0,
                deadband=dataclasses.replace(start.deadband, ratio=0.2),
                position=dataclasses.replace(start.position, gain=5.0),
            ),
        ]


def test_a_refused_change_carries_the_message_of_the_dataclass_and_changes_nothing():
    with ros() as peer:
        _, changes = bind(peer.node, "safety", SafetyParams)
        with pytest.raises(ParameterError) as own:
            SafetyParams(damper_velocity=2.0)
        reason = change(peer.node, safety__timeout_s=0.02, safety__damper_velocity=2.0)
        assert reason == f"safety.{own.value}"
        assert changes == []
        assert declared_values(peer.node, "safety", SafetyParams) == SafetyParams()


def declared_values(node, prefix, kind):
    return built(prefix, kind, {n: node.get_parameter(n).value for n in values_of(prefix, kind())})


def test_two_conflicting_values_may_change_together():
    """One after the other each would be refused."""
    with ros() as peer:
        _, changes = bind(peer.node, "safety", SafetyParams)
        assert change(peer.node, safety__damper_velocity=2.0, safety__fault_velocity=3.0) == ""
        assert changes == [SafetyParams(damper_velocity=2.0, fault_velocity=3.0)]


def test_zero_takes_an_optional_number_back():
    with ros() as peer:
        _, changes = bind(peer.node, "m", ContactParams, defaults=ContactParams(impedance=5.0))
        assert change(peer.node, m__impedance=0.001).startswith(
            "m.impedance = 0.001: must be 0.01"
        )
        assert change(peer.node, m__impedance=0.0) == ""
        assert changes == [ContactParams(impedance=None)]


def test_a_check_beyond_the_dataclass_refuses_at_the_start_and_later():
    def even(params):
        if params.impedance % 2:
            raise ParameterError("odd")

    with ros() as peer:
        defaults = MasterParams(impedance=2.0)
        _, changes = bind(peer.node, "m", MasterParams, defaults=defaults, check=even)
        assert change(peer.node, m__impedance=3.0) == "odd"
        assert change(peer.node, m__impedance=4.0) == ""
        assert len(changes) == 1
        with pytest.raises(ParameterError, match=r"^odd$"):
            bind(peer.node, "n", MasterParams, check=even)


def test_parameters_of_others_do_not_concern_the_binding():
    with ros() as peer:
        _, changes = bind(peer.node, "master", MasterParams)
        peer.node.declare_parameter("other", 1)
        assert change(peer.node, other=2) == ""
        assert changes == []
