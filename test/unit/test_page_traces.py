# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages that the live page reads and writes as bytes: the same as those of the middleware."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("rclpy")
from geometry_msgs.msg import PointStamped
from rclpy.serialization import deserialize_message, serialize_message

from pmwvc_core.controllers.accounts import OF_WAVES
from pmwvc_msgs.msg import MasterTrace, ServerTrace
from pmwvc_view.feed.accounts import ways
from pmwvc_view.feed.traces import F_H
from pmwvc_view.live import readers
from pmwvc_view.live.readers import MasterReader, ServerReader
from pmwvc_view.live.topics import target_bytes

COLUMNS = ("x", "xd", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")
ENERGIES = ("u_m", "u_tx", "v_rx", "v_m", "device", "hand")
STRICT = [entry.name for entry in OF_WAVES]
S = 1_000_000_000


def trace(ticks=8, dof=1, seed=1, *, known=True, **changes):
    """Return a trace of a master in which no two values are alike."""
    random = np.random.default_rng(seed)
    message = MasterTrace(dof=dof, state=2, period=1e-3, start_ns=5 + seed, epoch=2**63)
    message.stamp.sec, message.stamp.nanosec, message.seq = 7, 11, 13
    message.first_tick, message.missed, message.safety_events = 17, 2**40, 19
    message.hand_force_known = True
    for name in COLUMNS:
        setattr(message, name, random.normal(size=ticks * dof).tolist())
    if not known:
        message.hand_force_known, message.f_h = False, []
    for name in ENERGIES:
        setattr(message, f"energy_{name}", float(random.normal()))
    message.lateness, message.compute = random.random((2, ticks)).astype(np.float32).tolist()
    message.looked = random.integers(1, 2**32, ticks).tolist()
    for name in ("tick", "seq", "epoch"):  # of packets taken in: more or fewer in every message
        setattr(message, f"taken_{name}", random.integers(0, ticks, seed % 3).tolist())
    for name, value in changes.items():
        setattr(message, name, value)
    return message


def assert_block(block, message):
    """Assert that a block is a message that the middleware has read."""
    ticks, dof = len(message.lateness), message.dof
    for signal, name in zip(block.signals, COLUMNS[:3] + COLUMNS[4:6] + COLUMNS[7:], strict=True):
        wanted = getattr(message, name) if len(getattr(message, name)) else [np.nan] * ticks * dof
        np.testing.assert_array_equal(signal, np.reshape(wanted, (ticks, dof)), err_msg=name)
    assert block.lateness_s == list(message.lateness)
    assert (block.start_ns, block.state, block.reason, block.missed) == (
        *(message.start_ns, message.state, message.reason, message.missed),
    )
    late_ns = round(float(message.lateness[-1]) * S)
    kept = dict(zip(message.account_names, message.accounts, strict=True))
    np.testing.assert_array_equal(
        block.sums,
        (
            *(message.start_ns + (ticks - 1) * 1_000_000 + late_ns, message.epoch),
            *ways(message.energy_u_m, message.energy_u_tx, message.energy_v_m, kept),
            message.energy_device,
        ),
    )


messages = st.builds(
    trace,
    ticks=st.integers(1, 9),
    dof=st.just(2),
    seed=st.integers(0, 99),
    reason=st.sampled_from(["", "peer is silent", "é"]),
    account_names=st.sampled_from([[], ["tank"], STRICT, [*STRICT, "tank"]]).map(list),
    known=st.booleans(),
)


@given(st.lists(st.tuples(messages, st.integers(1, 3)), min_size=1, max_size=4))
def test_traces_of_a_master_are_read_as_the_middleware_reads_them(several):
    reader = MasterReader(dof=2, waves=True)
    for message, times in several:
        message.accounts = [0.5 + i for i in range(len(message.account_names))]
        for _ in range(times):
            message.start_ns += 8_000_000
            data = serialize_message(message)
            block = reader.read(data, None)
            assert_block(block, deserialize_message(data, MasterTrace))
    message.hand_force_known = False
    assert np.isnan(reader.read(serialize_message(message), None).signals[F_H]).all()


def server_trace(users=("user1", "user2"), dof=3, seed=1, **changes):
    random = np.random.default_rng(seed)
    message = ServerTrace(dof=dof, users=list(users), period=8e-3, start_ns=seed, epoch=3, step=9)
    for name, count in (("x_o", 1), ("xd_o", 1), ("target", 1), ("x_s", 2), ("xd_s", 2)):
        size = dof * (len(users) if count == 2 else 1)
        setattr(message, name, random.normal(size=size).tolist())
    for name in ("f_s", "u_s", "v_s"):
        setattr(message, name, random.normal(size=dof * len(users)).tolist())
    for name in ("energy_u_s", "energy_v_s"):
        setattr(message, name, random.random(len(users)).tolist())
    message.state = random.integers(0, 4, len(users)).tolist()
    message.contact = (random.random(len(users)) < 0.5).tolist()
    message.lateness = 0.25
    for name, value in changes.items():
        setattr(message, name, value)
    return message


@given(st.integers(1, 4), st.integers(1, 6), st.lists(st.integers(0, 99), min_size=1, max_size=4))
def test_traces_of_the_server_are_read_as_the_middleware_reads_them(count, dof, seeds):
    users = [f"user{i}" for i in range(1, count + 1)]
    reader = ServerReader(dof=dof, users=users)
    for seed in seeds:
        message = server_trace(users, dof, seed)
        step = reader.read(serialize_message(message))
        for found, name in zip(step.object, ("x_o", "xd_o", "target"), strict=True):
            np.testing.assert_array_equal(found, getattr(message, name))
        for found, name in zip(step.avatars, ("x_s", "xd_s", "f_s"), strict=True):
            np.testing.assert_array_equal(found.ravel(), getattr(message, name))
        assert list(step.state) == list(message.state)
        assert list(step.contact) == list(message.contact)
        for i, user in enumerate(users):
            ran_ns = seed + 250_000_000
            sums = (ran_ns, 3, message.energy_u_s[i], message.energy_v_s[i])
            assert step.sums[user] == sums


def test_messages_of_one_structure_cost_no_message_object(monkeypatch):
    read = []
    once = lambda data, kind: read.append(kind) or deserialize_message(data, kind)  # noqa: E731
    monkeypatch.setattr(readers, "deserialize_message", once)
    master, server = MasterReader(dof=1, waves=True), ServerReader(dof=3, users=["user1", "user2"])
    for seed in range(20):
        master.read(serialize_message(trace(seed=seed)), None)
        server.read(serialize_message(server_trace(seed=seed, state=[2, 2], contact=[True] * 2)))
    assert read == [MasterTrace, ServerTrace]


def test_trace_of_another_machine_is_put_beside_the_servers_and_its_energy_is_not_compared():
    data = serialize_message(trace())
    reader = MasterReader(dof=1, waves=True)
    own = reader.read(data, 7 * S)
    assert (own.start_ns, own.sums is None) == (6, False)
    other = reader.read(data, 5 * S)
    assert (other.start_ns, other.sums) == (2 * S + 11, None)


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
def test_traces_that_do_not_fit_are_skipped(changes):
    reader = MasterReader(dof=1, waves=True)
    for _ in range(2):
        assert reader.read(serialize_message(trace(**changes)), None) is None
        assert reader.read(serialize_message(trace()), None) is not None
    steps = ServerReader(dof=3, users=["user1", "user2"])
    assert steps.read(serialize_message(server_trace(("user1", "user3")))) is None
    assert steps.read(serialize_message(server_trace(state=[7, 0]))) is None


def test_what_is_no_trace_is_skipped():
    reader = MasterReader(dof=1, waves=True)
    data = serialize_message(trace())
    assert reader.read(data, None) is not None
    unread = {key: [] for key in ("looked", "taken_tick", "taken_seq", "taken_epoch")}
    for length in range(len(serialize_message(trace(**unread))) - 4 * (1 + len(unread))):
        assert reader.read(data[:length], None) is None
    assert reader.read(b"\0\1\0\0" + b"\xff" * 600, None) is None


@given(st.lists(st.floats(allow_nan=False), min_size=1, max_size=6), st.integers(0, 2**31 * S - 1))
def test_target_is_the_message_that_the_middleware_would_make(position, stamp_ns):
    found = deserialize_message(target_bytes(position, stamp_ns), PointStamped)
    stamp = found.header.stamp
    assert stamp.sec * S + stamp.nanosec == stamp_ns and found.header.frame_id == ""
    assert [found.point.x, found.point.y, found.point.z] == [*position, 0.0, 0.0][:3]
