# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Orientations in packets, and what devices and handles drift apart by turning: who repays it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from support.law_rigs import Users
from support.packer import Packer

from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.quaternions import IDENTITY, carried, unit
from pmwvc_core.transport.packet import Receipt
from pmwvc_core.transport.receiver import Receiver

H, LEVER_M, B = 0.008, 0.05, 25.0
numbers = st.floats(-1.0, 1.0)
directions = st.tuples(*[numbers] * 4).filter(lambda q: math.hypot(*q) > 0.1)


def along(q, size=1.0):
    return tuple(size / math.hypot(*q) * each for each in q)


@given(q=directions, last=directions, size=st.floats(0.9991, 1.0009))
def test_a_unit_quaternion_keeps_the_hemisphere_of_the_last(q, last, size):
    found = np.array(unit(along(q, size), last))
    assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-15)
    assert found @ last >= -1e-15
    same = Rotation.from_quat(found) * Rotation.from_quat(q).inv()
    assert same.magnitude() < 1e-7


@given(q=directions, size=st.one_of(st.floats(0.0, 0.9989), st.floats(1.0011, 1e300)))
def test_what_is_not_as_long_as_one_is_none(q, size):
    assert unit(along(q, size), IDENTITY) == ()


@given(q=directions, turn=st.tuples(*[st.floats(-3.0, 3.0)] * 3))
def test_a_turn_carries_an_orientation_as_a_rotation_vector_does(q, turn):
    expected = Rotation.from_rotvec(turn) * Rotation.from_quat(q)
    found = Rotation.from_quat(carried(along(q), turn))
    assert (found * expected.inv()).magnitude() < 1e-7


def packet(packer, **changes):
    made = packer.pack(np.zeros(6), np.zeros(6), 1_000_000 * packer.seq)
    for name, value in changes.items():
        setattr(made, name, value)
    return made


@pytest.mark.parametrize("wrong", [(0.0,) * 4, (0.0, 0.0, 0.0, 1.002), (), (1.0, 0.0, 0.0)])
def test_a_packet_of_six_axes_without_an_orientation_is_refused_and_counted(wrong):
    packer, receiver = Packer(7, period=H), Receiver(6, period_s=H, timeout_s=0.1)
    assert receiver.push(packet(packer), 0) is Receipt.NEW_EPOCH
    assert receiver.push(packet(packer, orientation=wrong), 1) is Receipt.MALFORMED
    assert receiver.push(packet(packer, orientation=(math.nan,) * 4), 2) is Receipt.NOT_FINITE
    flipped = packet(packer, orientation=(0.0, 0.0, 0.0, -1.0005))
    assert receiver.push(flipped, 3) is Receipt.ACCEPTED
    assert receiver.orientation == IDENTITY
    assert receiver.counts[Receipt.MALFORMED] == receiver.counts[Receipt.NOT_FINITE] == 1


class Air:
    """Handles in a viscous liquid; Cayley's step of each."""

    def __init__(self):
        self.turned = np.array([IDENTITY])

    def meet(self, drive, impedance, dt):
        v = drive / (impedance[:, None] + 2.0)
        turn = dt * v[0, 3:] / LEVER_M
        angle = 2.0 * math.atan(0.5 * np.linalg.norm(turn))
        turn *= angle / max(np.linalg.norm(turn), 1e-300)
        step = Rotation.from_rotvec(turn) * Rotation.from_quat(self.turned[0])
        self.turned = step.as_quat()[None]
        return v


def circled(duration_s, compensation, *, hz=2.0, rad=0.3, frames=4):
    """Turn a device about an axis that circles, then rest; return what is left of it [deg]."""
    server = ServerParams(coupling="unknown", environment="body", compensation=compensation)
    ports = Users(server, [ContactParams()], axes=6, environment=Air())
    outside, x = ports.s.body.environment, np.zeros(6)
    line_up, line_down = ([np.zeros(6)] * frames for _ in range(2))
    places = [(x, IDENTITY)] * frames
    before, given_j = Rotation.identity(), 0.0
    ports.join(0, x)
    for step in range(round((duration_s + 2.0) / H)):
        time_s = step * H
        size = rad * min(time_s, 1.0, max(duration_s - time_s, 0.0))
        angle = 2.0 * math.pi * hz * time_s
        device = Rotation.from_rotvec([size * math.cos(angle), size * math.sin(angle), 0.0])
        moved = np.append(np.zeros(3), LEVER_M * (device * before.inv()).as_rotvec())
        x, before = x + moved, device
        v = line_down.pop(0)
        line_up.append(math.sqrt(2.0 * B) * moved / H - v)
        places.append((x, tuple(device.as_quat())))
        outside.turned.devices[0] = places.pop(0)
        u = line_up.pop(0)
        (v,) = ports.step([u])
        line_down.append(v)
        given_j += 0.5 * H * (u @ u - v @ v)
        assert given_j >= -1e-12
    handle = Rotation.from_quat(outside.environment.turned[0])
    return math.degrees((device * handle.inv()).magnitude())


def test_device_and_handle_do_not_drift_apart_by_turns_that_circle():
    """Nor in three minutes, 0.0 degrees; here a part of these."""
    assert circled(10.0, "ledger") < 0.3


def test_without_repayment_they_drift_apart():
    assert circled(10.0, "none") > 3.0


def deceived(seed, compensation):
    """Let a device that hardly moves claim to turn; yield what came in at the port [J]."""
    server = ServerParams(coupling="unknown", environment="body", compensation=compensation)
    ports = Users(server, [ContactParams()], axes=6, environment=Air())
    rng, turned = np.random.default_rng(seed), ports.s.body.environment.turned
    turned.repays = True
    ports.join(0, np.zeros(6))
    for _ in range(200):
        q = Rotation.from_rotvec(rng.normal(0.0, 0.5, 3)).as_quat()
        turned.devices[0] = ports.x_s[0], tuple(q)
        ports.step([1e-3 * rng.normal(size=6)])
        yield ports.taken_j


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_ledger_pays_for_what_is_repaid_whatever_a_device_says(seed):
    assert min(deceived(seed, "ledger")) >= -1e-12


def test_without_a_ledger_it_would_come_from_nowhere():
    assert min(deceived(1, "none")) < -1e-6
