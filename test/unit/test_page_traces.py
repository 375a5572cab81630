# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Traces of masters read from their bytes: the same as the middleware reads."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("rclpy")
from rclpy.serialization import deserialize_message, serialize_message

from pmwvc_msgs.msg import MasterTrace
from pmwvc_view.live.inlets import master_trace
from pmwvc_view.live.trace_bytes import TraceBytes

COLUMNS = ("x", "xd", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")
NUMBERS = (
    "energy_u_m",
    "energy_u_tx",
    "energy_v_rx",
    "energy_v_m",
    "energy_device",
    "energy_hand",
)


def trace(ticks=8, dof=1, reason="", seed=1, **changes):
    """Return a trace in which no two values are alike."""
    random = np.random.default_rng(seed)
    message = MasterTrace(dof=dof, state=2, reason=reason, period=1e-3, start_ns=-5, epoch=2**63)
    message.stamp.sec, message.stamp.nanosec, message.seq = 7, 11, 13
    message.first_tick, message.missed, message.safety_events = 17, 2**40, 19
    message.hand_force_known = True
    for name in COLUMNS:
        setattr(message, name, random.normal(size=ticks * dof).tolist())
    for name in NUMBERS:
        setattr(message, name, float(random.normal()))
    message.lateness, message.compute = random.random((2, ticks)).astype(np.float32).tolist()
    for name, value in changes.items():
        setattr(message, name, value)
    return message


def assert_same(found, wanted):
    for name in wanted.get_fields_and_field_types():
        value, other = getattr(found, name), getattr(wanted, name)
        if name == "stamp":
            value, other = (value.sec, value.nanosec), (other.sec, other.nanosec)
        np.testing.assert_array_equal(value, other, err_msg=name)


@given(st.integers(1, 40), st.integers(1, 6), st.text("abcé ", max_size=20), st.integers(0, 99))
def test_bytes_are_read_as_the_middleware_reads_them(ticks, dof, reason, seed):
    data = serialize_message(trace(ticks, dof, reason, seed))
    assert_same(TraceBytes(data), deserialize_message(data, MasterTrace))


@pytest.mark.parametrize(
    "changes",
    [
        {"f_h": [], "hand_force_known": False},
        {"account_names": ["tank"], "accounts": [0.5]},
        {"accounts": [0.5]},
        {"u_m": [1.0] * 7},
        {"compute": [1.0] * 9},
        {name: [] for name in (*COLUMNS, "lateness", "compute")},
    ],
)
def test_traces_that_are_not_ordinary_are_left_to_the_middleware(changes):
    data = serialize_message(trace(**changes))
    with pytest.raises((ValueError, struct.error)):
        TraceBytes(data)
    assert_same(master_trace(data), deserialize_message(data, MasterTrace))


def test_what_is_no_trace_is_skipped():
    data = serialize_message(trace())
    for length in range(len(data) - 8):
        assert master_trace(data[:length]) is None
    assert master_trace(b"\0\1\0\0" + b"\xff" * 600) is None
