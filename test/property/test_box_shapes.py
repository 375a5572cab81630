# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Boxes that are no cubes: free spin, table, sides, and the contacts that they show; and boxes in
sessions.
"""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from property.test_box import SIDES, G, H, facing, squeezed
from scipy.spatial.transform import Rotation

from pmwvc_bringup.scenarios import load
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import BodyParams
from pmwvc_core.scenes.body import Box
from pmwvc_core.server.black_box import EnvironmentSetup
from pmwvc_core.simulation.session import simulate
from pmwvc_view.feed.rows import samples


def spun(made, rate, turns):
    """Let a box without weight spin from a rate in its own axes [rad/s]; yield after every step
    what changed of its energy [J] and momentum [N m s], each over what it had.
    """
    inertia = made._masses[3:]
    made._rates[3:] = rate
    energy_j, momentum = made.energy, inertia * rate
    for _ in range(round(turns * 2.0 * np.pi / (np.linalg.norm(rate) * H))):
        made.meet(np.zeros((1, 6)), np.full(1, 20.0), H)
        now = made._poses.turned[0] @ (inertia * made._rates[3:])
        lost = np.linalg.norm(now - momentum) / np.linalg.norm(momentum)
        yield abs(made.energy / energy_j - 1.0), float(lost)


shapes = st.lists(st.floats(0.025, 0.1), min_size=3, max_size=3)


def slab(size_m, **own):
    server = ServerParams(
        coupling="unknown", environment="body", object_mass=0.2, object_size_m=size_m[0],
        body=BodyParams(gravity=0.0, width_m=size_m[1], height_m=size_m[2], **own),
    )  # fmt: skip
    made = Box(EnvironmentSetup(6, H, (-1,), server, (ContactParams(),)))
    made._poses.at[0, 2] = 1.0  # high above the table
    made._points = made._points._replace(depth=made._points.depth - 1.0)
    return made


@settings(max_examples=15, deadline=None, phases=[Phase.generate])
@given(size_m=shapes, seed=st.integers(0, 2**32 - 1), rad_s=st.floats(2.0, 30.0))
def test_a_box_of_any_shape_that_spins_freely_keeps_energy_and_momentum(size_m, seed, rad_s):
    axis = np.random.default_rng(seed).normal(size=3)
    rate = rad_s / np.linalg.norm(axis) * axis
    assert max(map(max, spun(slab(size_m), rate, 1.0))) < 1e-12


def test_a_box_that_spins_by_eulers_steps_does_not():
    """The control, on the longest way about: the middle axis, where a small wobble grows."""
    size_m, rate = np.array([0.1, 0.06, 0.02]), np.array([0.1, 15.0, 0.1])
    inertia = (np.sum(size_m**2) - size_m**2) / 12.0
    energies, w = [np.sum(inertia * rate**2)], rate
    for _ in range(round(2.0 * np.pi / (15.0 * H))):
        w = w - H * np.cross(w, inertia * w) / inertia
        energies.append(np.sum(inertia * w**2))
    assert abs(energies[-1] / energies[0] - 1.0) > 1e-9
    *_, (energy, momentum) = spun(slab(size_m.tolist()), rate, 1.0)
    assert max(energy, momentum) < 1e-12


def test_a_flat_box_rests_on_its_table_and_is_lifted_by_its_sides():
    server = ServerParams(
        coupling="unknown", environment="body", object_mass=0.2, object_size_m=0.08,
        body=BodyParams(width_m=0.05, height_m=0.03),
    )  # fmt: skip
    contact = ContactParams(contact_stiffness=2000.0)
    made = Box(EnvironmentSetup(6, H, SIDES[:2], server, (contact,) * 2))
    assert made.description["shapes"][1]["size"] == [0.04, 0.025, 0.015]
    made.meet(np.zeros((2, 6)), np.full(2, 25.0), H)
    rows = np.array(made.contacts).reshape(-1, 8)
    assert (rows[:, :2] == [0.0, -1.0]).all() and len(rows) == 4
    assert rows[:, 7].sum() == pytest.approx(-0.2 * G)
    np.testing.assert_allclose(np.abs(rows[:, 2:5]), [[0.04, 0.025, 0.015]] * 4, atol=1e-4)
    for user, side in enumerate(SIDES[:2]):
        made.join(user, facing(side, 6) * 0.0401)
    places = squeezed(made, 3.0, 3.0, lift_m=0.04)
    assert places[-1][1][2] > 0.038
    rows = np.array(made.contacts).reshape(-1, 8)
    for user in (1.0, 2.0):
        own = rows[rows[:, 0] == user]
        assert (own[:, 1] == 0.0).all() and len(own) == 3
        assert own[:, 7].sum() == pytest.approx(0.1 * G, rel=0.01)
        assert abs(own[:, 5].sum()) == pytest.approx(3.0, rel=0.01)


def test_a_recording_and_its_page_have_the_contacts_of_a_box_that_is_lifted():
    traces = simulate([load("lift_body", duration_s=6.0)])[0]
    server = traces.server
    rows = server.contacts
    for step, carried_n in ((100, 0.0), (len(server.step) - 1, 0.2 * G)):
        now = rows[rows[:, 0] == step]
        of_hands, of_table = now[now[:, 2] == 0.0], now[now[:, 2] == -1.0]
        assert of_hands[:, 8].sum() == pytest.approx(carried_n, abs=1e-2)
        assert of_table[:, 8].sum() == pytest.approx(carried_n - 0.2 * G, abs=1e-2)
        assert (np.diff(np.linalg.norm(now[:, 6:], axis=1)) <= 0.0).all()
    (shown,) = [each for each in samples(traces) if each.column == "contacts"]
    assert np.isfinite(shown.values[-1]).sum() == 6 * 6  # of three points on each side


def test_hands_turn_a_box_over_a_network():
    traces = simulate([load("turn", duration_s=6.0)])[0]
    poses = {name: Rotation.from_quat(np.roll(rows[-1, 3:], -1)) for name, rows in
             traces.server.poses.items()}  # fmt: skip
    assert set(poses) == {"box", "user1", "user2"}
    for turned in poses.values():
        np.testing.assert_allclose(turned.as_rotvec(), [0.0, 0.0, 0.5], atol=0.03)
    assert traces.server.poses["box"][-1, 2] > 0.02
    for user in traces.users:
        way = Rotation.identity()
        for step in np.diff(user.x_m[:, 3:], axis=0, prepend=0.0):
            way = Rotation.from_rotvec(step / ServerParams().lever_m) * way
        up, down = (traces.packets[f"/{n}"].orientation[-1] for n in
                    (f"{user.name}/wave_up", f"server/{user.name}/wave_down"))  # fmt: skip
        for found in (up, user.orientation[-1]):
            assert (Rotation.from_quat(found) * way.inv()).magnitude() < 1e-3
        assert (Rotation.from_quat(down) * poses[user.name].inv()).magnitude() < 1e-9
