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
from support.plain import load

from pmwvc_core.controllers.accounts import OF_STRICT
from pmwvc_core.frame import SIGNALS
from pmwvc_core.traces import ENERGIES
from pmwvc_msgs.msg import MasterTrace, ServerTrace
from pmwvc_view.feed.tape import Tape
from pmwvc_view.live.topics import TraceReader, target_message

COLUMNS = ("x", "xd", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")
STRICT = [entry.name for entry in OF_STRICT]
USERS = ("user1", "user2")
S = 1_000_000_000


def reader(dof=1):
    return TraceReader(Tape(load("live"), live=True), dof=dof)


def read(message, dof=1):
    return reader(dof).of_master("user1", [serialize_message(message)])


def read_server(message, dof=1):
    return reader(dof).of_server([serialize_message(message)])


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


@pytest.mark.parametrize("names", [[], STRICT, [*STRICT, "tank"]])
@pytest.mark.parametrize(("ticks", "dof", "known"), [(1, 1, True), (9, 3, False)])
def test_trace_of_a_master_is_read_with_all_that_a_page_shows(names, ticks, dof, known):
    accounts = [0.5 + i for i in range(len(names))]
    message = trace(ticks, dof, account_names=names, accounts=accounts, hand_force_known=known)
    found = read(message, dof)
    for name, own in zip(COLUMNS, SIGNALS, strict=True):
        wanted = getattr(message, name) if known or name != "f_h" else [math.nan] * ticks * dof
        signal = getattr(found, own)
        np.testing.assert_array_equal(signal, np.reshape(wanted, (ticks, dof)), err_msg=own)
    assert found.lateness_s.tolist() == list(message.lateness)
    np.testing.assert_allclose(found.time_s, 1e-3 * np.arange(ticks))
    assert (found.state.tolist(), found.reason, found.missed) == ([2], ["é"], 2**40)
    assert [found.energy[name].tolist() for name in ENERGIES] == [[float(n)] for n in range(6)]
    assert {name: each.tolist() for name, each in found.accounts.items()} == {
        name: [joules] for name, joules in zip(names, accounts, strict=True)
    }


def test_force_of_a_hand_may_be_left_out():
    assert np.isnan(read(trace(hand_force_known=False, f_h=[])).f_h).all()


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
    found = read_server(message, dof)
    for name in ("x_o", "xd_o", "target"):
        np.testing.assert_array_equal(getattr(found, name)[0], getattr(message, name))
    for name in ("x_s", "xd_s", "f_s"):
        np.testing.assert_array_equal(np.ravel(getattr(found, name)), getattr(message, name))
    assert [each.tolist() for each in found.energy_u_s] == [[e] for e in message.energy_u_s]
    assert [each.tolist() for each in found.state] == [[2], [3]]
    assert [each.tolist() for each in found.contact] == [[False], [True]]
    assert (found.time_s.tolist(), found.step.tolist()) == ([0.0], [9])


@pytest.mark.parametrize(
    ("server_s", "start_s", "compared"), [(7, 1e-9, True), (5, 2.0 + 1e-9, False)]
)
def test_trace_of_another_machine_is_put_beside_the_servers_and_its_energy_is_not_compared(
    server_s, start_s, compared
):
    own = reader()
    step = server_trace()
    step.stamp.sec, step.stamp.nanosec = server_s, 10  # ahead of its monotonic clock by 5 ns less
    assert own.of_server([serialize_message(step)]) is not None
    found = own.of_master("user1", [serialize_message(trace())])
    assert found.time_s[0] == pytest.approx(start_s, abs=1e-12)
    assert np.isfinite(found.energy["u_m"]).all() == compared


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
    assert read(trace(**changes)) is None


@pytest.mark.parametrize(
    "message", [server_trace(("user1", "user3")), server_trace(state=[7, 0]), server_trace(dof=3)]
)
def test_trace_of_the_server_that_does_not_fit_is_skipped(message):
    assert read_server(message) is None


def test_what_is_no_trace_is_skipped():
    data, own = serialize_message(trace()), reader()
    assert own.of_master("user1", [data]) is not None
    broken = [data[:length] for length in range(0, len(data) - 60, 7)]
    assert own.of_master("user1", [*broken, b"\0\1\0\0" + b"\xff" * 600]) is None


def test_traces_that_came_together_are_one():
    later = serialize_message(trace(start_ns=8_000_006, first_tick=8))
    found = reader().of_master("user1", [serialize_message(trace()), b"", later])
    assert found.tick.tolist() == list(range(16))
    np.testing.assert_allclose(found.time_s, 1e-3 * np.arange(16))


@given(st.lists(st.floats(allow_nan=False), min_size=1, max_size=6), st.integers(0, 2**31 * S - 1))
def test_target_is_a_message_of_its_time_and_place(position, stamp_ns):
    found = target_message(position, (0.0, 0.6, 0.0, 0.8), stamp_ns)
    stamp = found.header.stamp
    assert stamp.sec * S + stamp.nanosec == stamp_ns and found.header.frame_id == ""
    at, q = found.pose.position, found.pose.orientation
    assert [at.x, at.y, at.z] == [*position, 0.0, 0.0][:3]
    assert [q.x, q.y, q.z, q.w] == [0.0, 0.6, 0.0, 0.8]
