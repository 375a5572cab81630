# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages of the nodes as the live page takes them, and targets that it publishes as bytes."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("rclpy")
from rclpy.serialization import serialize_message

from pmwvc_core.controllers.accounts import OF_STRICT
from pmwvc_msgs.msg import MasterTrace, ServerTrace
from pmwvc_view.feed.tape import KEPT
from pmwvc_view.live.topics import TraceReader, target_message

COLUMNS = ("x", "xd", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")
SHOWN = ("x", "xd", "f_h", "f_applied", "u_m", "v_m", "f_m")
STRICT = [entry.name for entry in OF_STRICT]
USERS = ("user1", "user2")
S = 1_000_000_000


def reader(dof=1):
    return TraceReader(dof=dof, users=USERS, waves=True)


def trace(ticks=8, dof=1, **changes):
    """Return a trace of a master in which no two values are alike."""
    random = np.random.default_rng(ticks)
    message = MasterTrace(dof=dof, state=2, reason="é", period=1e-3, start_ns=6, epoch=2**63)
    message.stamp.sec, message.stamp.nanosec = 7, 11
    message.missed, message.hand_force_known = 2**40, True
    for name in COLUMNS:
        setattr(message, name, random.normal(size=ticks * dof).tolist())
    for number, name in enumerate(("u_m", "u_tx", "v_rx", "v_m", "device", "hand")):
        setattr(message, f"energy_{name}", float(number))
    message.lateness, message.compute = random.random((2, ticks)).astype(np.float32).tolist()
    message.looked = random.integers(1, 2**32, ticks).tolist()
    for name, value in changes.items():
        setattr(message, name, value)
    return message


@pytest.mark.parametrize(
    ("names", "sums"),
    [
        ([], (0.0, 3.0, 4.0)),
        (["tank"], (math.nan, math.nan, 4.0)),  # something at the device answers the wave
        (STRICT, (1.0, 3.0 + 0.5 + STRICT.index("playout_released"), 4.0)),  # what was paid
        ([*STRICT, "tank"], (1.0, math.nan, 4.0)),
    ],
)
@pytest.mark.parametrize(("ticks", "dof", "known"), [(1, 1, True), (9, 3, False)])
def test_trace_of_a_master_is_read_with_all_that_a_page_shows(names, sums, ticks, dof, known):
    accounts = [0.5 + i for i in range(len(names))]
    message = trace(ticks, dof, account_names=names, accounts=accounts, hand_force_known=known)
    block = reader(dof).block(serialize_message(message))
    for signal, name, own in zip(block.signals, SHOWN, KEPT, strict=True):
        wanted = getattr(message, name) if known or name != "f_h" else [math.nan] * ticks * dof
        np.testing.assert_array_equal(signal, np.reshape(wanted, (ticks, dof)), err_msg=own)
    assert block.lateness_s == list(message.lateness)
    assert (block.start_ns, block.period_ns, block.epoch) == (6, 1_000_000, 2**63)
    assert (block.state, block.reason, block.missed) == (2, "é", 2**40)
    np.testing.assert_array_equal(block.sums, sums)


def test_force_of_a_hand_may_be_left_out():
    block = reader().block(serialize_message(trace(hand_force_known=False, f_h=[])))
    assert np.isnan(block.signals[KEPT.index("f_h")]).all()


def server_trace(users=USERS, dof=1, **changes):
    random = np.random.default_rng(1)
    message = ServerTrace(dof=dof, users=list(users), period=8e-3, start_ns=5, epoch=3, step=9)
    for name in ("x_o", "xd_o", "target"):
        setattr(message, name, random.normal(size=dof).tolist())
    for name in ("x_s", "xd_s", "f_s", "u_s", "v_s"):
        setattr(message, name, random.normal(size=dof * len(users)).tolist())
    message.energy_u_s, message.energy_v_s = random.random((2, len(users))).tolist()
    message.state, message.contact, message.lateness = [2, 3], [False, True], 0.25
    for name, value in changes.items():
        setattr(message, name, value)
    return message


@pytest.mark.parametrize("dof", [1, 3])
def test_trace_of_the_server_is_read_with_all_that_a_page_shows(dof):
    message = server_trace(dof=dof)
    step = reader(dof).step(serialize_message(message))
    for found, name in zip(step.object, ("x_o", "xd_o", "target"), strict=True):
        np.testing.assert_array_equal(found, getattr(message, name))
    for found, name in zip(step.avatars, ("x_s", "xd_s", "f_s"), strict=True):
        np.testing.assert_array_equal(found.ravel(), getattr(message, name))
    np.testing.assert_array_equal(step.sums, [message.energy_u_s, message.energy_v_s])
    assert (list(step.state), list(step.contact)) == ([2, 3], [False, True])
    assert (step.start_ns, step.epoch, step.lateness_s) == (5, 3, 0.25)


@pytest.mark.parametrize(
    ("server_s", "start_ns", "compared"), [(7, 6, True), (5, 2 * S + 6, False)]
)
def test_trace_of_another_machine_is_put_beside_the_servers_and_its_energy_is_not_compared(
    server_s, start_ns, compared
):
    own = reader()
    step = server_trace()
    step.stamp.sec, step.stamp.nanosec = server_s, 10  # ahead of its monotonic clock by 5 ns less
    assert own.step(serialize_message(step)) is not None
    block = own.block(serialize_message(trace()))
    assert (block.start_ns, block.sums is not None) == (start_ns, compared)


@pytest.mark.parametrize(
    "changes",
    [
        {"dof": 2},
        {"start_ns": 2**62},
        {"lateness": [0.0] * 7 + [float("nan")]},
        {"u_m": [1.0] * 7},
        {"compute": [1.0] * 9},
        {"state": 9},
        {"accounts": [0.5]},
        {name: [] for name in (*COLUMNS, "lateness", "compute")},
    ],
)
def test_trace_of_a_master_that_does_not_fit_is_skipped(changes):
    assert reader().block(serialize_message(trace(**changes))) is None


@pytest.mark.parametrize(
    "message", [server_trace(("user1", "user3")), server_trace(state=[7, 0]), server_trace(dof=3)]
)
def test_trace_of_the_server_that_does_not_fit_is_skipped(message):
    assert reader().step(serialize_message(message)) is None


def test_what_is_no_trace_is_skipped():
    data = serialize_message(trace())
    assert reader().block(data) is not None
    for length in range(0, len(data) - 60, 7):
        assert reader().block(data[:length]) is None
    assert reader().block(b"\0\1\0\0" + b"\xff" * 600) is None


@given(st.lists(st.floats(allow_nan=False), min_size=1, max_size=6), st.integers(0, 2**31 * S - 1))
def test_target_is_a_message_of_its_time_and_place(position, stamp_ns):
    found = target_message(position, stamp_ns)
    stamp = found.header.stamp
    assert stamp.sec * S + stamp.nanosec == stamp_ns and found.header.frame_id == ""
    assert [found.point.x, found.point.y, found.point.z] == [*position, 0.0, 0.0][:3]
