# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A box that turns, slips and falls between pads: energy of every step, friction, turning."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from support.law_rigs import Users

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import BodyParams
from pmwvc_core.plugins import Unanswered
from pmwvc_core.scenes.body import Box
from pmwvc_core.server.black_box import EnvironmentSetup

G, H, LEVER_M = 9.81, 0.008, 0.05
SIDES = -1, 1, 1, -1


def box(users=2, dof=6, *, mass=0.2, stiffness=2000.0, damping=10.0, **own):
    """Return a box with pads at its faces: left, right, right, left."""
    server = ServerParams(
        coupling="unknown", environment="body", object_mass=mass, body=BodyParams(**own)
    )
    contact = ContactParams(contact_stiffness=stiffness, contact_damping=damping)
    made = Box(EnvironmentSetup(dof, H, SIDES[:users], server, (contact,) * users))
    for user, side in enumerate(SIDES[:users]):
        made.join(user, facing(side, dof) * 0.0301)
    return made


def facing(side, dof):
    """Return the outward normal of a side's face."""
    return np.eye(dof)[0] * side


def matrix(rng, dof):
    """Return any symmetric positive matrix with eigenvalues of 4 to 60 N s/m."""
    axes, _ = np.linalg.qr(rng.normal(size=(dof, dof)))
    return (axes * rng.uniform(4.0, 60.0, dof)) @ axes.T


def squeezed(made, squeeze, seconds, *, b=25.0, lift_m=0.0):
    """Press with a squeeze [N] and follow a lift; return places of the first pad and the box."""
    users, dof = len(made._there), made._dof
    x, v, places = np.zeros((users, dof)), np.zeros((users, dof)), []
    for step in range(round(seconds / H)):
        wanted = np.zeros(dof)
        wanted[2] = lift_m * min(max(step * H - 1.0, 0.0), 1.0)
        push = 1000.0 * (wanted - x) - 5.0 * v
        push[:, 0] = [-side * squeeze for side in SIDES[:users]]
        v = made.meet(push + b * v, np.full(users, b), H)
        x = x + H * v
        places.append((x[0].copy(), made.position.copy()))
    return places


@settings(max_examples=12, deadline=None, phases=[Phase.generate])  # to shrink takes minutes
@given(
    seed=st.integers(0, 2**32 - 1), users=st.integers(1, 4), dof=st.sampled_from([3, 6]),
    stiffness=st.floats(100.0, 1e6), damping=st.sampled_from([0.0, 1.0, 10.0, 100.0]),
    friction=st.floats(0.0, 1.5), mass=st.floats(0.05, 2.0), coupled=st.booleans(),
    width_m=st.floats(0.03, 0.1), height_m=st.floats(0.03, 0.1),
)  # fmt: skip
def test_what_goes_in_is_held_or_heat_in_every_step(seed, users, dof, coupled, **values):
    """Sticking, slipping, tumbling, impacts, behind numbers and matrices: the balance to rounding,
    and no heat comes back. The control: by the matrices' diagonals it would not balance.
    """
    rng = np.random.default_rng(seed)
    made, b = box(users, dof, **values), np.full(users, rng.uniform(5.0, 80.0))
    matrices = np.array([matrix(rng, dof) if coupled else each * np.eye(dof) for each in b])
    amplitude, phase = rng.uniform(0.0, 6.0, (users, dof)), rng.uniform(0.0, 6.3, (users, dof))
    bias = -4.0 * np.array([facing(side, dof) for side in SIDES[:users]])
    given_j, by_diagonal_j, before_j, moved_j, heat_j = 0.0, 0.0, made.energy, 0.0, 0.0
    for step in range(80):
        drive = bias + amplitude * np.sin(10.0 * step * H + phase)
        v = made.meet(drive, matrices if coupled else b, H)
        power = (drive - np.einsum("uij,uj->ui", matrices, v)) * v
        given_j += H * power.sum()
        by_diagonal_j += H * np.sum((drive - np.einsum("uii,ui->ui", matrices, v)) * v)
        moved_j += H * np.abs(power).sum()
        inside_j = made.energy - before_j + made.heat_j
        assert abs(given_j - inside_j) < 1e-14 * (1.0 + moved_j)
        assert made.heat_j > heat_j - 1e-12 * (1.0 + moved_j)
        heat_j = made.heat_j
    assert not coupled or abs(by_diagonal_j - inside_j) > 1e-5 * moved_j


@pytest.mark.parametrize("seed", [2, 4])
def test_pads_that_wedge_a_tumbling_box_come_to_balance(seed):
    """Four unlike pads on springs, mu above 1: friction bounded once found none after 0.5 s."""
    rng = np.random.default_rng(seed)
    users, dof = int(rng.integers(2, 5)), int(rng.choice([3, 6]))
    made = box(
        users, dof, mass=rng.uniform(0.05, 0.3), stiffness=10 ** rng.uniform(3, 6),
        damping=rng.choice([0.0, 10.0]), friction=rng.uniform(1.2, 1.5),
        width_m=0.03 + 0.07 * rng.random(), height_m=0.03 + 0.07 * rng.random(), pad_m=0.01,
    )  # fmt: skip
    home = np.array([facing(side, dof) * 0.0301 for side in SIDES[:users]])
    home[:, 1:3] = rng.uniform(-0.015, 0.015, (users, 2))
    for user in range(users):
        made.join(user, home[user])
    x, bias = home.copy(), -10.0 * np.array([facing(side, dof) for side in SIDES[:users]])
    amplitude, phase = rng.uniform(0.0, 15.0, (users, dof)), rng.uniform(0.0, 6.0, (users, dof))
    rates = 2.0 * np.pi * rng.uniform(0.2, 5.0, (users, dof))
    b, before_j, given_j, moved_j = 20.0, made.energy, 0.0, 0.0
    for step in range(80):
        drive = bias + amplitude * np.sin(rates * step * H + phase) + 200.0 * (home - x)
        v = made.meet(drive, np.full(users, b), H)
        x, work_j = x + H * v, H * (drive - b * v) * v
        given_j, moved_j = given_j + work_j.sum(), moved_j + np.abs(work_j).sum()
        assert abs(given_j - made.energy + before_j - made.heat_j) < 1e-13 * (1.0 + moved_j)


@pytest.mark.parametrize("dof", [3, 6])
@pytest.mark.parametrize(("mass", "mu"), [(2.0, 0.6), (0.2, 1.2)])
@pytest.mark.parametrize("spare", [0.9, 1.15])
def test_two_pads_lift_what_friction_holds(dof, mass, mu, spare):
    """Coulomb: 2 mu N against the weight; what is held does not creep."""
    made = box(2, dof, mass=mass, friction=mu)
    places = squeezed(made, spare * 0.5 * mass * G / mu, 4.0, lift_m=0.04)
    slipped = [float(pad[2] - middle[2]) for pad, middle in places]
    if spare > 1.0:
        sags_m = 0.5 * mass * G * (1.0 / 1000.0 + 1.0 / 2000.0)  # of hand and contact
        assert places[-1][1][2] == pytest.approx(0.04 - sags_m, abs=5e-4)
        assert abs(slipped[-1] - slipped[-126]) < 1e-4
    else:
        assert places[-1][1][2] < 2e-3


def test_a_box_between_two_pads_turns_as_they_do():
    """Free of weight, both pads twist about the axis between them: rate drive/(b l)."""
    made, drive = box(2, gravity=0.0), np.zeros((2, 6))
    drive[:, 0], drive[:, 2] = (5.0, -5.0), 0.5
    for _ in range(125):
        made.meet(drive, np.full(2, 20.0), H)
    drive[:, 2] = 0.0
    turn = Rotation.from_quat(np.roll(made.poses["box"][3:], -1))
    assert turn.magnitude() < 1e-9
    drive[:, 3] = 0.5
    seconds = 2.0
    for _ in range(round(seconds / H)):
        made.meet(drive, np.full(2, 20.0), H)
    rate = 0.5 / (20.0 * LEVER_M)
    turned = [
        Rotation.from_quat(np.roll(pose[3:], -1)).as_rotvec() for pose in made.poses.values()
    ]
    for pad in turned[1:]:
        np.testing.assert_allclose(pad, turned[0], atol=0.05)
    assert turned[0][0] == pytest.approx(rate * seconds, abs=0.05)
    assert made.position[3] / LEVER_M == pytest.approx(turned[0][0], abs=1e-5)
    assert made.velocity[3] / LEVER_M == pytest.approx(rate, rel=1e-3)


@pytest.mark.parametrize("spare", [0.8, 1.2])
def test_a_pad_twists_off_above_mu_times_force_times_its_radius(spare):
    press, mu, pad_m = 5.0, 0.5, 0.01
    made, drive = box(2, gravity=0.0, friction=mu, pad_m=pad_m), np.zeros((2, 6))
    drive[:, 0] = press, -press
    drive[:, 3] = np.array([1.0, -1.0]) * spare * mu * press * pad_m / LEVER_M
    for _ in range(500):
        v = made.meet(drive, np.full(2, 20.0), H)
    if spare < 1.0:
        assert abs(v[0, 3]) < 1e-6
    else:  # the bristles are a tenth of the radius
        assert v[0, 3] == pytest.approx(drive[0, 3] * (1.0 - 1.0 / spare) / 20.0, rel=0.05)


@pytest.mark.parametrize("inside_m", [1e-6, 0.004, 0.02])
def test_who_joins_inside_begins_without_force_and_slides_out(inside_m):
    made = box(2, 3, gravity=0.0)
    made.join(0, facing(-1, 3) * (0.03 - inside_m))
    b = np.full(2, 20.0)
    assert np.abs(made.meet(np.zeros((2, 3)), b, H)).max() == 0.0
    for push, steps in ((1.0, 100), (-1.0, 100), (1.0, 300)):
        for _ in range(steps):
            v = made.meet(np.array([[push, 0.0, 0.0], [-max(push, 0.0), 0.0, 0.0]]), b, H)
        pad_m = made.poses["user1"][0]
        depth_m = 0.03 - abs(pad_m - made.poses["box"][0])
        if push > 0.0:
            np.testing.assert_allclose(v, 0.0, atol=1e-6)
            assert depth_m == pytest.approx(1.0 / 2000.0 + inside_m * (steps == 100), rel=1e-3)
        else:
            assert depth_m < 0.0


def test_an_avatar_is_where_the_box_has_it_whatever_came_too_late():
    asked = iter(range(1000))

    def call(exchange):
        answer = exchange()
        if next(asked) % 3 == 0:
            raise Unanswered("has not answered")
        return answer

    server = ServerParams(coupling="unknown", environment="body")
    ports, rng = Users(server, [ContactParams()] * 2, axes=6, call=call), np.random.default_rng(3)
    for user, side in enumerate((-1, 1)):
        ports.join(user, facing(side, 6) * 0.03)
    for step in range(200):
        ports.step(list(rng.normal(0.0, 0.3, (2, 6))))
        poses = ports.s.body.environment.environment.poses
        if step % 3:
            for user, port in enumerate(ports.s.ports):
                np.testing.assert_allclose(port.x_s[:3], poses[f"user{user + 1}"][:3], atol=1e-9)
    assert ports.faults.steps == 67


def test_four_axes_are_refused():
    server = ServerParams(coupling="unknown", environment="body")
    setup = EnvironmentSetup(4, H, (-1,), server, (ContactParams(),))
    with pytest.raises(ParameterError, match=r"dof = 4: environment 'body' has 3 or 6 axes"):
        Box(setup)
