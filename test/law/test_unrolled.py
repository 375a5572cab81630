# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws unrolled for one number of axes give the bits of their source."""

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from pmwvc_core.law.vectors import (
    dot,
    each,
    length,
    minus,
    plus,
    scaled,
    shortened,
    squared,
    times,
    within,
    zero,
)
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.bulk.loop import session
from pmwvc_core.simulation.bulk.run import can_run, run
from pmwvc_core.unrolled import unrolled

CONFIG = Path(__file__).resolve().parents[2] / "pmwvc_bringup" / "config"


@pytest.mark.parametrize(
    ("name", "dof", "channel"),
    [("carry_16ms", 1, "plain"), ("wifi_bursty", 3, "strict"), ("three_users", 2, "zeroing")],
)
def test_a_session_has_the_bits_of_its_source(name, dof, channel):
    mapping = yaml.safe_load((CONFIG / f"{name}.yaml").read_text("utf-8"))
    scenario = parse_scenario(mapping | {"channel": channel, "dof": dof, "duration_s": 1.5})
    assert can_run(scenario)
    one, other = run(scenario, session), run(scenario, unrolled(session, scenario.dof))
    for field, wanted, got in zip(one.book._fields, one.book, other.book, strict=True):
        assert np.array_equal(wanted, got, equal_nan=True), field


def arithmetic(a, b, c):
    """Every primitive, with values worked out in place and used more than once."""
    more = plus(scaled(a, length(b)), minus(b, a))
    most = max(dot(more, b), min(c, squared(times(a, b))))
    near = within(shortened(more, abs(c)), max(abs(c), 1.0))
    return more, most, near, minus(a, b) == zero(a), zero(a)


arithmetic.__module__ = "pmwvc_core.law.arithmetic"
numbers = st.floats(-1e6, 1e6) | st.sampled_from([math.nan, math.inf, -0.0])


@given(ab=st.data(), c=numbers)
@pytest.mark.parametrize("axes", [1, 2, 3])
def test_the_primitives_are_those_of_the_source(axes, ab, c):
    ab = ab.draw(st.tuples(*[st.tuples(*[numbers] * axes)] * 2))
    wanted, got = arithmetic(*ab, c), unrolled(arithmetic, axes)(*ab, c)
    assert repr(got) == repr(wanted)  # not-a-number equals itself


def over_users(rows, b):
    """A law on rows of another number than that of the axes."""
    return each(arithmetic, (rows,), b, 0.5)


over_users.__module__ = "pmwvc_core.law.arithmetic"


@pytest.mark.parametrize("users", [1, 2, 3, 5])
def test_rows_may_be_of_any_number(users):
    rows = tuple((float(k), 1.0 + k) for k in range(users))
    assert unrolled(over_users, 2)(rows, (0.5, 2.0)) == over_users(rows, (0.5, 2.0))
