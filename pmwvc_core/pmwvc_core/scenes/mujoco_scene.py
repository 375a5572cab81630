# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A MuJoCo scene as an environment that answers an impedance, for any number of users.

The port is f = sqrt(2b) u - b v. In a sub-step h of the solver it enters as an armature A = h b of
the three slides and a force that knows the velocity before it::

    (m + h b) (v(n+1) - v(n))/h = [sqrt(2b) u - b v(n)] + contacts
        <=>  m (v(n+1) - v(n))/h = sqrt(2b) u - b v(n+1) + contacts

so the contact solver sees the impedance, and what is held may weigh a gram. With the mean velocity
V of all sub-steps the port gives F = sqrt(2b) u - b V, and F V >= mean f v, as V^2 <= mean v^2:
what the port counts is not less than what went in. Of six axes the last three are a turn in world
axes, as the way of a point at the lever l: a ball with the armature h b l^2. MuJoCo's contacts and
joints are not proved passive; the ledger of the port holds on top
(:mod:`pmwvc_core.law.black_box.compensations`).

Who is not there is held still and touches nothing. The origin of the devices is the centre of mass
of the first body that moves (the scene's origin where none does); each finger's is shifted along
axis 0, to meet that body where it would meet an object of ``server.object_size_m``. A finger that
comes in within another body passes through it until it is outside. Equations: docs/theory.md 5.16.
"""

from typing import Any

import numpy as np

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import AXES, Array
from pmwvc_core.quaternions import IDENTITY, carried, turn_between
from pmwvc_core.scenes.description import described, strongest
from pmwvc_core.scenes.model import Grasp, import_mujoco, scene_model
from pmwvc_core.server.black_box import EnvironmentSetup, matrices_of, times_rows

OVERLAP_M = 1e-4  # that is none
SETTLE_S = 2.0
STILL_KG = 1e9  # armature of what nobody holds
LARGEST_M_S = 1e3  # faster is no motion
FAR_M, APPROACHES = 100.0, 50  # of a finger to a face; one does where it is across axis 0
W_LAST, W_FIRST = [1, 2, 3, 0], [3, 0, 1, 2]  # of quaternions: w is first in MuJoCo


class MujocoScene:
    """The scene of ``server.scene``; ``position`` [m] and mean ``velocity`` [m/s], each
    ``(dof,)``, are those of the first body that moves, from where it began.
    """

    couples = True

    def __init__(self, setup: EnvironmentSetup) -> None:
        self._mujoco, self._dof, self._lever_m = import_mujoco(), setup.dof, setup.server.lever_m
        self._scale = np.repeat([1.0, self._lever_m], 3)[: self._dof]  # of ports' axes to bodies'
        self._whole = self._mujoco.mjtState.mjSTATE_INTEGRATION
        self.model, self.held, self._shown, self._made_of = scene_model(setup)
        self.data, self._scratch = (self._mujoco.MjData(self.model) for _ in range(2))
        self._colliding = self.model.geom_contype.copy(), self.model.geom_conaffinity.copy()
        self._names = [self.model.body(n).name or f"body{n}" for n in range(self.model.nbody)]
        moving = self.model.body_weldid != 0  # what is welded to the world has 0
        self._moving = np.flatnonzero(moving).tolist()
        place = np.where(moving, np.cumsum(moving) - 1, -1)[self.model.geom_bodyid]
        self._place = np.append(place, -1)  # of geoms, among what moves; -1 is no geom, but a flex
        self._dofs = np.array([np.r_[held.dofs] for held in self.held])  # (users, dof)
        self._axes = np.tile(np.eye(self._dof), (setup.users, 1, 1))  # of handles, in the world
        self._axes[:, :3, :3] = [held.axes for held in self.held]
        self._slides = self._axes.copy()  # b is the same about all axes of a ball
        self._apart = self._dof == AXES or not np.allclose(self._axes, np.eye(self._dof))
        self._whose = np.full(len(self._place), -1)  # of geoms, who holds them
        self._there, self._inside = [False] * setup.users, [False] * setup.users
        for user, held in enumerate(self.held):
            self._whose[held.geoms] = user
            self.leave(user)
        self._settle(setup)
        self._origin = self.data.xipos[self._shown].copy()
        for user, side in enumerate(setup.sides):
            self._begin_at_face(user, side, 0.5 * setup.server.object_size_m)
        self.position, self.velocity = np.zeros(setup.dof), np.zeros(setup.dof)
        self._turned = self.data.xquat[self._shown, W_LAST].tolist()
        self._good = np.empty(self._mujoco.mj_stateSize(self.model, self._whole))
        self._require_motion()
        self._note()

    def _note(self) -> None:
        """Note contacts, and the poses of what moves: x y z [m], quaternion w x y z, by name."""
        rows = np.concatenate([self.data.xpos, self.data.xquat], axis=1).tolist()
        self.poses = {self._names[body]: rows[body] for body in self._moving}
        self.contacts, press = strongest(self.data, self._place, self._whose >= 0)
        self.touching = np.isin(range(len(self.held)), self._whose[press]).tolist()

    @property
    def turned(self) -> Array:
        """How the handles are turned, quaternions ``x y z w``."""
        return np.array([self.data.xquat[held.body, W_LAST] for held in self.held])

    @property
    def description(self) -> dict[str, Any]:
        """What is constant, with where the devices' origin is (:mod:`.description`)."""
        drawn = described(self.model, self.data, self._names, self._whose.tolist())
        return {**drawn, "origin": self._origin.tolist(), **self._made_of}

    def join(self, user: int, position: Array) -> None:
        """Put a finger where the avatar is, ``(dof,)`` [m]; a handle is taken where it is."""
        held = self.held[user]
        if held.home is not None:
            self.data.qpos[held.qpos] = (held.home + position[:3]) @ held.axes
            if self._dof == AXES:
                turned = carried(IDENTITY, (position[3:] / self._lever_m).tolist())
                self.data.qpos[held.ball] = np.array(turned)[W_FIRST]
        self.data.qvel[held.dofs] = 0.0
        self._there[user], self._inside[user] = True, True

    def leave(self, user: int) -> None:
        """Hold still what a user held."""
        held, self._there[user] = self.held[user], False
        self._weigh(held, np.full(self._dof, STILL_KG))
        self._touches(held, False)

    def meet(self, drive: Array, impedance: Array, dt: float) -> Array:
        """Go on by ``dt`` [s] (:class:`pmwvc_core.server.black_box.BlackBox`)."""
        model, scale, impedance = self.model, self._scale, matrices_of(impedance, self._dof)
        steps, slides = int(np.ceil(dt / model.opt.timestep - 1e-9)), self._slides
        model.opt.timestep = dt / steps  # not longer than before, whatever the period became
        along = (slides.swapaxes(1, 2) @ impedance @ slides).diagonal(0, 1, 2) * scale**2
        for user, held in enumerate(self.held):
            if self._there[user]:
                self._weigh(held, model.opt.timestep * along[user])
                self._inside[user] = self._inside[user] and self._comes_out(user)
        try:
            rates: Array = scale / steps * self._sub_steps(drive * scale, along, steps)
        finally:  # also where MuJoCo's collisions raised, with what is no number
            self._require_motion()
        self._mujoco.mj_kinematics(model, self.data)
        self._note()
        self._show(dt)
        return rates

    def _sub_steps(self, drive: Array, along: Array, steps: int) -> Array:
        """Make sub-steps under the ports' forces, sqrt(2b) u in the world and b along the axes of
        the handles; return the sum of their velocities.
        """
        data, dofs = self.data, self._dofs
        absent = dofs[~np.array(self._there)]
        rates = np.zeros(drive.shape)
        self._note_axes()
        for _ in range(steps):
            push = times_rows(self._axes.swapaxes(1, 2), drive) if self._apart else drive
            data.qfrc_applied[dofs] = push - along * data.qvel[dofs]
            data.qfrc_applied[absent] = data.qvel[absent] = 0.0
            self._mujoco.mj_step(self.model, data)
            self._note_axes()
            rates += times_rows(self._axes, data.qvel[dofs]) if self._apart else data.qvel[dofs]
        return rates

    def _note_axes(self) -> None:
        """Note the axes of motion of the handles: a ball's turn with it."""
        if self._dof != AXES:
            return
        turned = np.empty(9)
        for axes, held in zip(self._axes, self.held, strict=True):
            self._mujoco.mju_quat2Mat(turned, self.data.qpos[held.ball])
            axes[3:, 3:] = held.start @ turned.reshape(3, 3)

    def _show(self, dt: float) -> None:
        """Note where the first body that moves is, and how it turned."""
        way = self.data.xipos[self._shown] - self._origin - self.position[:3]
        before, self._turned = self._turned, self.data.xquat[self._shown, W_LAST].tolist()
        if self._dof == AXES:
            way = np.append(way, self._lever_m * np.array(turn_between(before, self._turned)))
        self.position, self.velocity = self.position + way, way / dt

    def _weigh(self, held: Grasp, armature: Array) -> None:
        """Set an armature, and what MuJoCo derives from it for the weights of contacts."""
        if (self.model.dof_armature[held.dofs] != armature).any():
            self.model.dof_armature[held.dofs] = armature
            self._mujoco.mj_setConst(self.model, self._scratch)

    def _touches(self, held: Grasp, on: bool) -> None:
        self.model.geom_contype[held.geoms] = self._colliding[0][held.geoms] * on
        self.model.geom_conaffinity[held.geoms] = self._colliding[1][held.geoms] * on
        self._mujoco.mj_setConst(self.model, self._scratch)  # their body's, too

    def _comes_out(self, user: int) -> bool:
        """Let a user touch from where nothing is overlapped; tell whether something still is."""
        held = self.held[user]
        self._touches(held, True)
        inside = any(set(pair) & set(held.geoms) for pair in self._overlaps())
        self._touches(held, not inside)
        return inside

    def _overlaps(self) -> list[tuple[int, int]]:
        """Return the pairs of geoms that overlap by more than ``OVERLAP_M``; a flex has -1."""
        self._mujoco.mj_fwdPosition(self.model, self.data)  # of flexes, too
        inside = (c for c in self.data.contact if c.dist < c.includemargin - OVERLAP_M)
        return [pair for c in inside if max(pair := (int(c.geom1), int(c.geom2))) >= 0]

    def _settle(self, setup: EnvironmentSetup) -> None:
        """Refuse a scene whose bodies overlap at the start, or let it settle."""
        if setup.server.settle:
            for _ in range(round(SETTLE_S / self.model.opt.timestep)):
                self._mujoco.mj_step(self.model, self.data)
            self.data.qvel[:] = 0.0
        elif pairs := self._overlaps():
            geoms = [self.model.geom(each) for each in pairs[0] if each >= 0]
            names = [repr(g.name or f"a geom of {self._names[g.bodyid[0]]}") for g in geoms]
            text = f"{' and '.join([*names, 'a flex'][:2])} overlap, which moves them"
            ways = "move one, or set server.settle = true"
            raise ParameterError(f"server.scene = {setup.server.scene!r}: {text}; {ways}")

    def _begin_at_face(self, user: int, side: int, half_m: float) -> None:
        """Set where a user's finger is for a device at zero; unshifted where it finds no face."""
        held, model, distance = self.held[user], self.model, self._mujoco.mj_geomDistance
        if held.home is None:
            return
        touched = (model.geom_contype | model.geom_conaffinity) > 0
        faces = np.flatnonzero(touched & (model.geom_bodyid == (self._shown or -1))).tolist()
        finger, held.home[:] = held.geoms[0], self._origin
        unshifted_m = held.home[0] = self._origin[0] + side * model.geom_size[finger, 0]
        for _ in range(APPROACHES):
            self.join(user, side * half_m * np.eye(self._dof)[0])
            self._mujoco.mj_kinematics(model, self.data)
            far_m = [distance(model, self.data, face, finger, FAR_M, None) for face in faces]
            gap_m = float(np.min(far_m - model.geom_margin[faces], initial=FAR_M))
            if abs(gap_m) < OVERLAP_M:
                break
            held.home[0] -= side * gap_m
        else:
            held.home[0] = unshifted_m
        self.leave(user)

    def _require_motion(self) -> None:
        """Raise where the scene has become unstable, with the last good state back."""
        speeds = np.abs(self.data.qvel)
        if np.isfinite(self.data.qpos).all() and (speeds < LARGEST_M_S).all():
            self._mujoco.mj_getState(self.model, self.data, self._good, self._whole)
            return
        worst = self._names[self.model.dof_bodyid[np.argmax(np.nan_to_num(speeds, nan=np.inf))]]
        self._mujoco.mj_setState(self.model, self.data, self._good, self._whole)
        raise RuntimeError(f"the scene became unstable at body {worst!r}; a good state is back")
