# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Axes, scale and clutch of a device make no energy, no step of the avatar and none of the force,
whenever the hand is uncoupled: against the device's own motion and force, tick by tick.
"""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from support.session_given import session_given
from support.vendor_setup import vendor_setup

from pmwvc_core.errors import DeviceError, ParameterError
from pmwvc_core.frame import DeviceSample
from pmwvc_core.law.safety.limits import FADE_S
from pmwvc_core.made.user import made_user
from pmwvc_core.params import DeviceParams, SafetyParams, ServerParams
from pmwvc_core.scenario.scenario import User
from pmwvc_master.devices import DeviceInfo
from pmwvc_master.devices.mapped import Mapped

TICKS, TICK_S, SLEW_N_S = 400, 0.001, 200.0
ORDERS = [
    " ".join(sign + axis for sign, axis in zip(signs, order, strict=True))
    for order in itertools.permutations("xyz")
    for signs in itertools.product(("", "-"), repeat=3)
]


class Handle:
    """A handle moved as a row of positions says; it notes the forces that it was given."""

    def __init__(self, x, *, buttons=0, axes=""):
        self.x, self.dof = x, x.shape[1]
        self.info = DeviceInfo("handle", self.dof, axes=axes, buttons=buttons)
        self.xd = np.diff(x, axis=0, prepend=x[:1]) / TICK_S
        self.forces, self.tick, self.pressed, self.valid = [], 0, np.zeros(len(x), bool), True

    def open(self): ...
    def couple(self): ...
    def close(self): ...

    def stop(self):
        self.write(np.zeros(self.dof) if self.dof > 1 else 0.0)

    def read(self, due_ns):
        k, self.tick = self.tick, self.tick + 1
        x, xd = (v if self.dof > 1 else float(v[0]) for v in (self.x[k], self.xd[k]))
        return DeviceSample(x, xd, 0.0 * x, self.valid, buttons=2 * int(self.pressed[k]))

    def write(self, f_m):
        self.forces.append(np.atleast_1d(f_m))


def smooth(rng, dof, size):
    """Return a random motion that begins anywhere."""
    x = np.cumsum(np.cumsum(rng.normal(size=(TICKS, dof)), axis=0), axis=0)
    return size * (x / np.abs(x).max() + rng.normal(size=dof))


def limited(rng, dof, scale):
    """Return forces of the loop whose steps are within its slew."""
    steps = rng.normal(size=(TICKS, dof))
    steps *= SLEW_N_S * TICK_S / scale / np.linalg.norm(steps, axis=1, keepdims=True)
    return 3.0 / scale * rng.normal(size=dof) * (rng.random() < 0.5) + np.cumsum(steps, axis=0)


def presses(rng, times):
    """Return when the button is pressed: it changes a few times."""
    edges = np.sort(rng.integers(0, TICKS, times))
    return np.searchsorted(edges, np.arange(TICKS), side="right") % 2 == 1


def played(handle, f, *, scale=1.0, kind=Mapped, dof=None, **device):
    """Return positions and velocities that the loop saw."""
    dof = dof or handle.dof
    setup = vendor_setup(
        "handle", dof, scale=scale, clutch=2 * (handle.info.buttons > 0), **device
    )
    made = kind(handle, setup)
    made.slew_n = SLEW_N_S * TICK_S
    xs, xds = [], []
    for k in range(TICKS):
        sample = made.read(k)
        xs.append(np.atleast_1d(sample.x))
        xds.append(np.atleast_1d(sample.xd))
        made.write(f[k] if dof > 1 else float(f[k, 0]))
    return np.array(xs), np.array(xds)


runs = given(
    st.integers(0, 2**32 - 1), st.sampled_from([1, 2, 3, 6]), st.floats(0.1, 10.0),
    st.integers(0, 8), st.sampled_from(ORDERS),
)  # fmt: skip


@settings(max_examples=20)
@runs
def test_energy_position_and_force_at_any_presses(seed, dof, scale, times, axes):
    rng = np.random.default_rng(seed)
    handle = Handle(smooth(rng, dof, 0.1), buttons=2)
    handle.pressed = presses(rng, times)
    f = limited(rng, dof, max(scale, 1.0 / scale) if dof == 6 else scale)
    axes = axes if dof in (3, 6) else ""
    x, xd = played(handle, f, scale=scale, axes=axes)
    forces, moved = np.array(handle.forces), np.diff(handle.x, axis=0)
    taken, given_j = np.sum(f[:-1] * np.diff(x, axis=0)), np.sum(forces[:-1] * moved)
    through = np.abs(f[:-1] * np.diff(x, axis=0)).sum()
    assert abs(taken - given_j) <= 1e-12 * (1.0 + through)
    steps = np.linalg.norm(np.diff(x, axis=0), axis=1)
    largest = max(scale, 1.0) if dof == 6 else scale
    assert (steps <= largest * np.linalg.norm(moved, axis=1) + 1e-12).all()
    np.testing.assert_allclose(np.diff(x, axis=0), xd[1:] * TICK_S, atol=1e-12)
    changes = np.linalg.norm(np.diff(forces, axis=0), axis=1)
    # With six axes the loop limits force and torque together: what a scale makes of a step.
    assert changes.max() <= SLEW_N_S * TICK_S * (1.0 + 1e-9)


@settings(max_examples=20)
@runs
def test_an_uncoupled_hand_moves_nothing_and_feels_nothing(seed, dof, scale, times, axes):
    rng = np.random.default_rng(seed)
    handle, axes = Handle(smooth(rng, dof, 0.1), buttons=2), axes if dof in (3, 6) else ""
    handle.pressed = np.arange(TICKS) >= 100
    f = np.broadcast_to(rng.normal(size=dof), (TICKS, dof)) / scale
    x, xd = played(handle, f, scale=scale, axes=axes)
    whole = np.linalg.norm(handle.forces[99])
    after = 101 + int(max(FADE_S, whole / SLEW_N_S) / TICK_S) + 1
    assert not np.any(handle.forces[after:]) and not xd[after + 1 :].any()
    assert (x[after + 1 :] == x[after + 1]).all()
    assert np.ptp(handle.x[after:], axis=0).max() > 0.0


class Naive(Mapped):
    """The control: the hand is let go and taken up at once, where it is."""

    def _coupling(self, f):
        self._shift = self._shift if self._c else tuple(0.0 for _ in self._shift)
        return 0.0 if self._uncoupled else 1.0


def test_a_clutch_that_only_switches_makes_steps():
    rng = np.random.default_rng(3)
    handle = Handle(smooth(rng, 3, 0.1), buttons=2)
    handle.pressed = presses(rng, 4)
    x, _ = played(handle, np.full((TICKS, 3), 2.0), kind=Naive)
    moved = np.linalg.norm(np.diff(handle.x, axis=0), axis=1)
    assert (np.linalg.norm(np.diff(x, axis=0), axis=1) - moved).max() > 0.01
    assert np.abs(np.diff(handle.forces, axis=0)).max() > 1.0


@pytest.mark.parametrize("scale", [0.25, 4.0])
@pytest.mark.parametrize("axis", [0, 4])
def test_with_six_axes_neither_force_nor_torque_of_the_device_exceeds_its_limit(scale, axis):
    """The limits that the loop is made with, behind the matrix."""
    session = session_given(channel="plain", dof=6, server=ServerParams())
    user = User("user1", given_device=DeviceParams(scale=scale), given_safety=SafetyParams())
    _, p = made_user(user, session)
    handle = Handle(np.zeros((TICKS, 6)))
    made = Mapped(handle, vendor_setup("handle", 6, scale=scale))
    made.read(0)
    made.write(p.limits.max_force * np.eye(6)[axis])
    assert np.abs(handle.forces[-1]).max() <= SafetyParams().max_force
    speed = p.limits.damper_velocity / (scale if axis < 3 else 1.0)
    assert speed <= SafetyParams().damper_velocity


def matrix_of(axes):
    """Return the matrix of axes, by hand."""
    matrix = np.zeros((3, 3))
    for row, word in enumerate(axes.split()):
        matrix[row, "xyz".index(word[-1])] = -1.0 if word[0] == "-" else 1.0
    return matrix


@pytest.mark.parametrize("axes", ORDERS[::11])
@pytest.mark.parametrize("dof", [1, 2, 3, 6])
def test_axes_are_an_orthogonal_matrix_and_a_turn_follows_them(dof, axes):
    """A mirror turns a turn, as it turns the cross product of two ways."""
    rng = np.random.default_rng(5)
    handle = Handle(smooth(rng, 6 if dof == 6 else 3, 0.1))
    x, _ = played(handle, np.zeros((TICKS, dof)), scale=2.0, dof=dof, axes=axes)
    matrix = matrix_of(axes)
    expected = 2.0 * handle.x[:, :3] @ matrix.T
    np.testing.assert_allclose(x[:, :3], expected[:, :dof], atol=1e-12)
    if dof == 6:
        a, b = rng.normal(size=(2, 3))
        turned = np.cross(matrix @ a, matrix @ b)
        spun = played(Handle(np.tile([0, 0, 0, *np.cross(a, b)], (TICKS, 1))),
                      np.zeros((TICKS, 6)), dof=6, axes=axes)[0]  # fmt: skip
        np.testing.assert_allclose(spun[0, 3:], turned, atol=1e-12)


def test_an_offset_moves_the_avatar_and_no_force():
    handle = Handle(smooth(np.random.default_rng(1), 3, 0.1))
    x, _ = played(handle, np.full((TICKS, 3), 1.0), offset_x_m=0.02, offset_z_m=-0.1)
    np.testing.assert_allclose(x - handle.x, np.tile([0.02, 0.0, -0.1], (TICKS, 1)), atol=1e-15)
    assert {float(each) for each in np.ravel(handle.forces)} == {1.0}


def test_a_device_that_is_away_and_a_number_that_is_none_leave_no_step_behind():
    handle = Handle(np.tile([[0.01, 0.02, 0.03]], (TICKS, 1)), buttons=2)
    made = Mapped(handle, vendor_setup("handle", 3, clutch=2))
    made.pressed = True
    for k in range(60):
        handle.x[k, 0] = np.nan if k in (5, 40) else 0.001 * k
        handle.valid = k not in (10, 11)
        sample = made.read(k)
        assert sample.valid == handle.valid
        made.write(np.ones(3))
    made.pressed = False
    assert made.uncoupled and np.isfinite(made.read(60).x).all()


@pytest.mark.parametrize(
    ("device", "text"),
    [
        ({"axes": "x x z"}, r"axes = 'x x z': must be x, y and z once each, like 'y -x z'"),
        ({"axes": "--x"}, r"axes = '--x': must be"),
    ],
)
def test_a_value_that_cannot_be_is_refused_in_a_line(device, text):
    with pytest.raises(ParameterError, match=text):
        DeviceParams(**device)


def test_what_a_device_has_not_is_refused_with_a_way_out():
    handle = Handle(np.zeros((TICKS, 2)), buttons=1)
    with pytest.raises(DeviceError, match=r"device\.axes = 'x y z': handle has x y; each must"):
        Mapped(handle, vendor_setup("handle", 2, axes="x y z"))
    with pytest.raises(DeviceError, match=r"clutch = 2: handle has 1 buttons; call ~/clutch inst"):
        Mapped(handle, vendor_setup("handle", 2, clutch=2))


@pytest.mark.parametrize("axes", ORDERS[::11])
def test_an_orientation_is_that_of_the_turned_axes_until_the_hand_is_uncoupled(axes):
    """The rotation of the device's own axes, by matrices; then it follows the way."""
    turned, turn = matrix_of(axes), Rotation.from_rotvec([0.2, -0.5, 0.4])
    handle = Handle(np.zeros((TICKS, 6)))
    sample = DeviceSample(np.zeros(6), np.zeros(6), np.zeros(6))
    sample.orientation = tuple(turn.as_quat().tolist())
    handle.read = lambda _: sample
    made = Mapped(handle, vendor_setup("handle", 6, axes=axes))
    found = Rotation.from_quat(made.read(0).orientation).as_matrix()
    np.testing.assert_allclose(found, turned @ turn.as_matrix() @ turned.T, atol=1e-12)
    made.pressed = True
    made.read(1)
    made.write(np.zeros(6))
    assert made.read(2).orientation == ()
