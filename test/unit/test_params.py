# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Every declared bound holds at the bound and not beyond it; every parameter says what it is."""

import pytest

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
    TaskParams,
    specs,
)
from pmwvc_core.params.fields import parameter

GROUPS = [
    ContactParams,
    DeviceParams,
    FilterParams,
    LinkParams,
    MasterParams,
    OperatorParams,
    SafetyParams,
    ServerParams,
    TaskParams,
]
EVERY = [(kind, name, spec) for kind in GROUPS for name, spec in specs(kind).items()]
IDS = [f"{kind.__name__}.{name}" for kind, name, _ in EVERY]


@pytest.mark.parametrize(("kind", "name", "spec"), EVERY, ids=IDS)
def test_a_value_just_outside_its_range_is_refused_by_name(kind, name, spec):
    step = 1 if spec.kind is int else 1e-9
    outside = [bound for bound in (spec.above, spec.below) if bound is not None]
    outside += [spec.low - step] if spec.low is not None else []
    outside += [spec.high * (1 + 1e-9) + step] if spec.high is not None else []
    outside += ["no such choice"] if spec.choices else []
    outside += [float("nan")] if spec.kind is float else []
    for value in outside:
        value = int(value) if spec.kind is int else value
        with pytest.raises(ParameterError, match=rf"^{name} = .*: must be "):
            kind(**{name: value})


@pytest.mark.parametrize(("kind", "name", "spec"), EVERY, ids=IDS)
def test_every_parameter_has_a_unit_and_a_description(kind, name, spec):
    assert spec.description
    assert spec.unit or spec.kind in (str, bool)


@pytest.mark.parametrize(("kind", "name", "spec"), EVERY, ids=IDS)
def test_an_inclusive_bound_itself_is_allowed(kind, name, spec):
    if kind is SafetyParams and name in ("damper_velocity", "fault_velocity"):
        return  # their order is checked as well
    for bound in (spec.low, spec.high):
        if bound is not None:
            value = spec.kind(bound)
            corner = kind is FilterParams and name in ("pole_rad_s", "cutoff_hz")
            others = {"kind": "first_order"} if corner else {}
            assert getattr(kind(**others, **{name: value}), name) == value


@pytest.mark.parametrize("text", ["0..1 s", ">= 0 N", "> 0 and <= 20 N", ">= 0 and < 1", "N", "-"])
def test_a_declared_range_is_what_messages_show(text):
    spec = parameter(0.5, text, "").metadata["spec"]
    assert spec.range_text().removeprefix("a number ") == ("a number" if text == "-" else text)


@pytest.mark.parametrize("text", [">0 N", "0...1", "=> 0 s", "0..1..2", "0..x s"])
def test_a_range_that_cannot_be_read_is_refused_where_it_is_declared(text):
    with pytest.raises(ValueError, match="must be a range"):
        parameter(0.5, text, "")
