# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A box that turns, slips and falls on a table, held between flat pads: an environment that
answers an impedance, along three axes or along six.

Of six axes, the last three are the turn of a handle, as the way of a point at the lever l from it:
way l theta [m], force torque/l [N], so that b along all six is b l^2 about an axis, and power is
power. World axes everywhere.

By the mean velocities of a step, v and w of the box and V and W of the handles, with the motion
J of every point by them (:mod:`.kinematics`) and the inertia I about the box's own axes::

    m (v1 - v0)/h = m g - sum Jv^T phi,   I (w1 - w0)/h + w x I w = -sum Jw^T phi,
    v = (v0 + v1)/2,   w = (w0 + w1)/2,   R1 = R0 cay(h w)
    b V = drive - sum JV^T phi,           b l^2 W = l drive_r - sum JW^T phi

w x I w does no work, and R1 I w1 - R0 I w0 = Rbar (I (w1 - w0) + h w x I w): a free box keeps
energy and momentum. phi . J h is what the forces of :mod:`.pressing` take up. Forces balance
nearly (:mod:`.newton`); box and handles then move as these forces make them, so that energy
balances to rounding, and the heat has what is left. Equations: docs/theory.md 5.18.
"""

from typing import Any

import numpy as np
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import AXES, Array
from pmwvc_core.quaternions import of_matrix
from pmwvc_core.scenes.kinematics import Poses, Shape, by_velocities, moved, points_at, slope_of
from pmwvc_core.scenes.newton import Trial, balanced
from pmwvc_core.scenes.pressing import Points, pressed, stored_j
from pmwvc_core.scenes.turning import cross
from pmwvc_core.server.black_box import EnvironmentSetup, matrices_of

POINTS = 3  # of a pad
TABLE_N_M, TABLE_S, SINKS = 2e4, 0.002, 0.025  # at least; damping of it; most of half the box
THIN_M, TABLE_M, NOT_TURNED = 0.001, 0.2, [1.0, 0.0, 0.0, 0.0]  # as drawn
GREY, WOOD = [0.5, 0.5, 0.5, 1.0], [0.8, 0.6, 0.3, 1.0]  # the first is the page's own colour
SETTLED, SETTLED_W, LEAST_N = 1e-13, 1e-24, 1e-9  # of what is wanted; of nothing; of a touch
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


class Box:
    """The box of ``server.object_mass``, as long as ``server.object_size_m`` along axis 0, on a
    table where it begins; ``position``, ``velocity``, ``(dof,)``, are those of the box.
    """

    couples = True

    def __init__(self, setup: EnvironmentSetup) -> None:
        if setup.dof not in (3, 6):
            raise ParameterError(f"dof = {setup.dof}: environment 'body' has 3 or 6 axes")
        server, own, users = setup.server, setup.server.body, setup.users
        if server.object_damping or not all(contact.grips for contact in setup.contacts):
            needed = "server.object_damping = 0 and server.contact = grip"
            raise ParameterError(f"environment 'body' slides and is pushed only: set {needed}")
        self._dof, self._lever_m = setup.dof, server.lever_m
        sides = [server.object_size_m, own.width_m, own.height_m]
        self._half_m = 0.5 * np.array([each or server.object_size_m for each in sides])
        self._mass, self._weight_n = server.object_mass, server.object_mass * own.gravity
        if own.pad_m > (least_m := float(min(self._half_m))):
            wrong = f"server.body.pad_m = {own.pad_m}: wider than a side of the box"
            raise ParameterError(f"{wrong}; {least_m} at most")
        inertia = self._mass / 3.0 * (np.sum(self._half_m**2) - self._half_m**2)
        self._masses = np.array([self._mass] * 3 + inertia.tolist())
        angle = np.arange(POINTS) * (2.0 * np.pi / POINTS)
        ring = own.pad_m * np.stack([0.0 * angle, np.cos(angle), np.sin(angle)], axis=-1)
        outward, pads = np.outer(setup.sides, [1.0, 0.0, 0.0]), np.repeat(np.arange(users), POINTS)
        self._shape = Shape(ring, pads, self._half_m * CORNERS, setup.dof)
        table_n_m = max(TABLE_N_M, self._weight_n / (4.0 * SINKS * self._half_m[2]))
        k = [contact.contact_stiffness / POINTS for contact in setup.contacts]
        damping = [contact.contact_damping / POINTS for contact in setup.contacts]

        def of_points(of_users: Any, of_corners: Any) -> Array:
            return np.concatenate([np.asarray(of_users)[pads], [of_corners] * 8])

        self._table_z = self._weight_n / (4.0 * table_n_m) - self._half_m[2]
        self._face_m = of_points([self._half_m[0]] * users, self._table_z)
        self._forces = np.zeros((len(self._face_m), 3))
        depth = np.append(0.0 * pads, self._table_z - self._half_m[2] * CORNERS[:, 2])
        self._points = Points(
            of_points(outward, [0.0, 0.0, 1.0]), depth, self._forces, of_points(k, table_n_m),
            of_points(damping, TABLE_S * table_n_m), np.full(len(depth), own.friction),
            np.arange(len(depth)) >= len(pads),
        )  # fmt: skip
        self._there = np.zeros(users, bool)
        self._poses = Poses(np.zeros((1 + users, 3)), np.tile(np.eye(3), (1 + users, 1, 1)))
        self._rates, self._guess = np.zeros(6), np.zeros(6 + setup.dof * users)
        self._stored_j, self.heat_j = stored_j(self._points), 0.0
        self.touching: Any = [False] * users
        self.position, self.velocity = np.zeros(setup.dof), np.zeros(setup.dof)
        self._names = ["table", "box", *(f"user{1 + user}" for user in range(users))]

    @property
    def energy(self) -> float:
        """What it holds [J]: of motion, in contacts, and of its weight above the table."""
        moving = 0.5 * float(np.sum(self._masses * self._rates**2))
        return moving + self._stored_j + self._weight_n * float(self._poses.at[0, 2])

    @property
    def poses(self) -> dict[str, list[float]]:
        """Where box and pads are, ``x y z`` [m] and quaternion ``w x y z``, by name."""
        turned = [[w, x, y, z] for x, y, z, w in map(of_matrix, self._poses.turned)]
        rows = np.hstack([self._poses.at, turned]).tolist()
        return dict(zip(self._names[1:], rows, strict=True))

    @property
    def contacts(self) -> list[float]:
        """Where points pressed in the last step, most first, 8 numbers each: two bodies by their
        place in ``poses`` (-1: the table), where [m], force on the second [N].
        """
        (c, *_), (r, *_) = self._poses
        points, forces = points_at(self._poses, self._shape), self._forces.copy()
        pads = len(self._shape.pads)
        points[:pads], forces[:pads] = points[:pads] @ r.T + c, forces[:pads] @ r.T
        first, second = np.append(1 + self._shape.pads, [0] * 8), [0] * pads + [-1] * 8
        rows = np.column_stack([first, second, points, forces])
        size = np.linalg.norm(forces, axis=-1)
        return list(rows[np.argsort(-size)][: np.count_nonzero(size > LEAST_N)].ravel().tolist())

    @property
    def turned(self) -> Array:
        """How the pads are turned, quaternions ``x y z w``."""
        return np.array([of_matrix(each) for each in self._poses.turned[1:]])

    @property
    def description(self) -> dict[str, Any]:
        """Shapes of table, box and pads, as those of :mod:`.description`."""
        pad = (np.abs(self._shape.ring).max(axis=0) + THIN_M).tolist()
        sizes = [[TABLE_M, TABLE_M, THIN_M], self._half_m.tolist(), *([pad] * len(self._there))]
        shapes = [
            {"body": name, "kind": "box", "size": size, "at": [0.0] * 3, "turned": NOT_TURNED,
             "rgba": WOOD if name == "box" else GREY, "user": max(user, -1)}
            for user, (name, size) in enumerate(zip(self._names, sizes, strict=True), -2)
        ]  # fmt: skip
        fixed = {"table": [0.0, 0.0, self._table_z - THIN_M, *NOT_TURNED]}
        return {"shapes": shapes, "fixed": fixed, "origin": [0.0] * 3}

    def join(self, user: int, position: Array) -> None:
        """Put a handle where the avatar is, ``(dof,)`` [m]."""
        self._there[user] = True
        self._poses.at[1 + user] = position[:3]
        turn = position[3:] / self._lever_m if self._dof == AXES else np.zeros(3)
        self._poses.turned[1 + user] = Rotation.from_rotvec(turn).as_matrix()
        self._points.can_touch[POINTS * user : POINTS * (user + 1)] = False

    def leave(self, user: int) -> None:
        """Take a handle away; what its contact held is lost."""
        self._there[user] = False

    def meet(self, drive: Array, impedance: Array, dt: float) -> Array:
        """Go on by ``dt`` [s] (:class:`pmwvc_core.server.black_box.BlackBox`)."""
        begun, before_j = self._begun(), self._stored_j  # points slid off: less is begun with
        scale = np.repeat([1.0, self._lever_m], 3)[: self._dof]
        wanted = np.append(2.0 / dt * self._masses * self._rates, drive * scale)
        wanted[2] -= self._weight_n
        b = matrices_of(impedance, self._dof) * np.outer(scale, scale)
        resists = block_diag(np.diag(2.0 / dt * self._masses), *b)
        inertia, shape, along = self._masses[3:], self._shape, resists.diagonal()
        enough_w = SETTLED**2 * float(wanted @ (wanted / along)) + SETTLED_W

        def tried(x: Array, bound: Array | None) -> Trial:
            poses = moved(self._poses, x, dt, shape)
            mean = Poses(*(0.5 * (a + b) for a, b in zip(self._poses, poses, strict=True)))
            by = by_velocities(mean, shape)
            after = pressed(begun, dt * by @ x, dt, bound)
            missing = resists @ x - wanted + after.force.ravel() @ by.reshape(-1, len(x))
            missing[3:6] += cross(x[3:6]) @ (inertia * x[3:6])

            def slope() -> Array:
                w, found = x[3:6], resists.copy()
                found[3:6, 3:6] += cross(w) * inertia - cross(inertia * w)
                return np.asarray(found + slope_of(after, by, w, mean, dt, shape))

            return Trial(x, missing, float(missing @ (missing / along)), slope, after, by)

        near, *_, after, by = balanced(tried, self._guess, enough_w, begun.friction)
        work = after.force.ravel() @ by.reshape(-1, len(near))
        resists[3:6, 3:6] -= cross(inertia * near[3:6])  # now linear: balanced to rounding
        x = np.linalg.solve(resists, wanted - work)
        poses = moved(self._poses, x, dt, shape)
        self._rates = 2.0 * x[:6] - self._rates
        self._poses, self._guess, self._forces = poses, x, after.force
        touch = after.pressing[: POINTS * len(b)] > LEAST_N
        self.touching = touch.reshape(len(b), -1).any(axis=1).tolist()
        depth = begun.depth - dt * np.sum(begun.normal * (by @ x), axis=-1)
        self._points = begun._replace(bristle=after.bristle, depth=depth)
        self._stored_j = stored_j(self._points)
        self.heat_j += before_j - self._stored_j + dt * float(work @ x)
        self.velocity = np.append(x[:3], self._lever_m * (poses.turned[0] @ x[3:6]))[: self._dof]
        self.position = self.position + dt * self.velocity
        return np.asarray(x[6:].reshape(-1, self._dof) * scale)

    def _begun(self) -> Points:
        """Return the points at the beginning of a step. A point touches a face that it is over;
        one that comes from the side begins without force where it is.
        """
        begun, at, pads = self._points, points_at(self._poses, self._shape), len(self._shape.pads)
        height = np.sum(begun.normal * at, axis=-1)
        over = np.all(np.abs(at - height[:, None] * begun.normal) <= self._half_m, axis=-1)
        over[:pads] &= self._there[self._shape.pads]
        over[pads:] = True
        pressing = begun.can_touch & (begun.depth >= 0.0)
        depth = np.where(pressing, begun.depth, np.minimum(self._face_m - height, 0.0))
        return begun._replace(depth=depth, can_touch=over)
