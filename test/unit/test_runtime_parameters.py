# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters in ROS are those of the dataclasses: names, bounds and refusals, at any time."""

import sys

import pytest
from rcl_interfaces.msg import ParameterType
from rclpy.parameter import Parameter
from support.parameter_nodes import bind, change, node_given
from support.peers import ros

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import (
    ContactParams,
    DeviceParams,
    FilterParams,
    LinkParams,
    MasterParams,
    OperatorParams,
    SafetyParams,
    ServerParams,
    Spec,
    TaskParams,
)
from pmwvc_core.params.names import leaves
from pmwvc_core.runtime.parameter_values import built, values_of
from pmwvc_core.runtime.parameters import declare, declare_names, declare_value

GROUPS = [
    ContactParams,
    DeviceParams,
    LinkParams,
    MasterParams,
    OperatorParams,
    SafetyParams,
    ServerParams,
    TaskParams,
]


@pytest.mark.parametrize("kind", GROUPS, ids=lambda kind: kind.__name__)
def test_every_group_survives_the_way_through_ros(kind):
    with ros() as peer:
        assert declare(peer.node, "group", kind) == kind()
        assert built("a.b", kind, values_of("a.b", kind())) == kind()
        for name, spec in leaves("group", kind).items():
            descriptor = peer.node.describe_parameter(name)
            assert descriptor.read_only
            assert descriptor.description.startswith(spec.description)
            assert spec.unit in ("", "-") or f"[{spec.unit}]" in descriptor.description


IN_FLIGHT = [ContactParams, LinkParams, MasterParams, SafetyParams, ServerParams]


@pytest.mark.parametrize("kind", IN_FLIGHT, ids=lambda kind: kind.__name__)
def test_every_number_that_may_change_in_flight_is_bounded_on_both_sides(kind):
    for name, spec in leaves("", kind).items():
        if spec.kind in (int, float) and not spec.read_only:
            low = spec.above if spec.low is None else spec.low
            high = spec.below if spec.high is None else spec.high
            assert low is not None and high is not None, name
            assert max(abs(low), abs(high)) <= 1e12, name


@pytest.mark.parametrize("kind", GROUPS, ids=lambda kind: kind.__name__)
def test_every_bound_holds_in_ros_at_the_bound_and_not_beyond(kind):
    with ros() as peer:
        apart = {  # so that no other rule refuses a bound
            SafetyParams: SafetyParams(fault_velocity=20.0),
            MasterParams: MasterParams(filter=FilterParams(kind="first_order")),
        }
        bind(peer.node, "g", kind, defaults=apart.get(kind, kind()))
        for name, spec in leaves("g", kind).items():
            if spec.read_only or spec.kind not in (int, float):
                continue
            step = 1 if spec.kind is int else 1e-6
            for bound, outside in ((spec.low, -step), (spec.high, step)):
                if bound is None:
                    continue
                good = peer.node.set_parameters([Parameter(name, value=spec.kind(bound))])[0]
                assert good.successful, good.reason
                bad = Parameter(name, value=spec.kind(bound + outside * max(1, abs(bound))))
                refused = peer.node.set_parameters([bad])[0]
                assert not refused.successful
                assert name in refused.reason
                assert peer.node.get_parameter(name).value == bound
            if spec.optional:  # takes itself out of the way of the next one
                peer.node.set_parameters([Parameter(name, value=0.0)])


def test_a_type_and_an_inclusive_range_are_reported():
    with ros() as peer:
        bind(peer.node, "master", MasterParams)
        ticks = peer.node.describe_parameter("master.rate_drop")
        assert (ticks.type, ticks.read_only) == (ParameterType.PARAMETER_INTEGER, False)
        assert peer.node.describe_parameter("master.tick_s").read_only
        assert [(r.from_value, r.to_value) for r in ticks.integer_range] == [(1, 1000)]
        impedance = peer.node.describe_parameter("master.impedance")
        assert (impedance.type, impedance.read_only) == (ParameterType.PARAMETER_DOUBLE, False)
        assert impedance.additional_constraints == "0.01..1000 N s/m"
        (numbers,) = impedance.floating_point_range
        assert (numbers.from_value, numbers.to_value) == (0.01, 1000.0)


def test_a_bound_that_is_open_is_a_range_too_and_the_constraint_states_what_is_excluded():
    with ros() as peer:
        bind(peer.node, "device", DeviceParams)
        declare_value(peer.node, "seed", Spec(int, low=0, description="seed"), 1)
        mass = peer.node.describe_parameter("device.mass")
        (numbers,) = mass.floating_point_range
        assert (numbers.from_value, numbers.to_value) == (0.0, sys.float_info.max)
        assert mass.additional_constraints == "> 0 kg"
        assert change(peer.node, device__mass=0.0) == "device.mass = 0.0: must be > 0 kg"
        (integers,) = peer.node.describe_parameter("seed").integer_range
        assert (integers.from_value, integers.to_value) == (0, 2**63 - 1)


def test_what_the_node_was_given_wins_over_defaults_and_a_whole_number_is_a_number():
    with node_given(master__impedance=30, master__filter__cutoff_hz=7) as peer:
        defaults = MasterParams(
            impedance=10.0, hold="zoh", filter=FilterParams(kind="first_order")
        )
        start, _ = bind(peer.node, "master", MasterParams, defaults=defaults)
        assert start == MasterParams(
            impedance=30.0, hold="zoh", filter=FilterParams(kind="first_order", cutoff_hz=7.0)
        )
        assert peer.node.get_parameter("master.impedance").type_ == Parameter.Type.DOUBLE


def test_every_wrong_start_value_is_named_with_its_range():
    with (
        node_given(master__impedance=-3.0, master__hold="up", master__rate_drop=2.5) as peer,
        pytest.raises(ParameterError) as caught,
    ):
        declare(peer.node, "master", MasterParams)
    assert str(caught.value) == (
        "master.impedance = -3.0: must be 0.01..1000 N s/m; "
        "master.rate_drop = 2.5: must be a whole number, 1..1000; "
        "master.hold = 'up': must be one of zoh, foh"
    )


def test_single_values_are_checked_too():
    with node_given(users=[1, 2], seed=-1) as peer:
        with pytest.raises(ParameterError, match=r"^users = .*: must be a list of strings"):
            declare_names(peer.node, "users", [], "names")
        with pytest.raises(ParameterError, match=r"^seed = -1: must be >= 0"):
            declare_value(peer.node, "seed", Spec(int, low=0, description="seed"), 1)
