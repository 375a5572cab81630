# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""How points move that pads have on a box, and its corners over a table, in one step.

In a step h all motion is by mean velocities: v of the box and w in its own axes, V and W of the
handles in world axes. A bar is the mean of both ends. A point of a pad is at q = R^T (p - c) in
the box, a corner at y = c + R s in the world; their ways D = q1 - q0 and D = y1 - y0 are exact in
the velocities, by J = D/h::

    J = Rbar^T (V + W x abar) - Rbar^T v + rho x w,   rho = Rbar^T (pbar - cbar)
    J = v + Rbar (w x s)

For Newton's method (:mod:`.newton`): under forces phi that stay, J turns with the box, and the
ways of pads change by J at the end of the step; how handles turn themselves is left out::

    rows of w, and the transpose in the columns of the others:   h/2 [phi] J,   h/2 [s] [R^T phi]
    dD = h (1 - h [w]/2) J
"""

from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import AXES, Array, Integers
from pmwvc_core.scenes.pressing import Pressed
from pmwvc_core.scenes.turning import cayley, cross


class Poses(NamedTuple):
    """Where box and handles are: the first is the box, ``(1 + users, 3)`` and ``(..., 3, 3)``."""

    at: Array
    turned: Array


class Shape(NamedTuple):
    """Points of a pad in the axes of its handle ``(points, 3)`` [m], which handle each pads' point
    is of ``(pads,)``, the box's corners ``(8, 3)`` [m], and the axes of a handle.
    """

    ring: Array
    pads: Integers
    corners: Array
    dof: int


def moved(poses: Poses, x: Array, h: float, p: Shape) -> Poses:
    """Return the poses after a step by mean velocities."""
    rates, turning = x[6:].reshape(-1, p.dof), np.zeros(poses.at.shape)
    turning[0] = poses.turned[0] @ x[3:6]
    turning[1:, : p.dof - 3] = rates[:, 3:]
    at = poses.at + h * np.concatenate([x[None, :3], rates[:, :3]])
    return Poses(at, cayley(h * turning) @ poses.turned)


def points_at(poses: Poses, p: Shape) -> Array:
    """Return pads' points in the box's axes, its corners in the world's, ``(n, 3)`` [m]."""
    (c, *_), (r, *_) = poses
    rings = poses.at[1:, None] + p.ring @ poses.turned[1:].swapaxes(-1, -2)
    return np.concatenate([(rings.reshape(-1, 3) - c) @ r, c + p.corners @ r.T])


def by_velocities(mean: Poses, p: Shape) -> Array:
    """Return J ``(n, 3, unknowns)``: the rates of all points by the mean velocities. The matrices
    of the mean poses are no rotations.
    """
    (at, turned), r, pads = mean, mean.turned[0], len(p.pads)
    found = np.zeros((pads + len(p.corners), 3, 6 + p.dof * (len(at) - 1)))
    arms = (p.ring @ turned[1:].swapaxes(-1, -2)).reshape(-1, 3)
    rho = (at[1 + p.pads] + arms - at[0]) @ r
    found[:pads, :, :3], found[:pads, :, 3:6] = -r.T, cross(rho)
    found[pads:, :, :3], found[pads:, :, 3:6] = np.eye(3), -r @ cross(p.corners)
    own = found[:, :, 6:].reshape(len(found), 3, -1, p.dof)  # of each user's handle
    own[np.arange(pads), :, p.pads, :3] = r.T
    if p.dof == AXES:
        own[np.arange(pads), :, p.pads, 3:] = -r.T @ cross(arms)
    return found


def slope_of(after: Pressed, by: Array, w: Array, mean: Poses, h: float, p: Shape) -> Array:
    """Return the slope of J^T phi by the velocities, ``(unknowns, unknowns)``."""
    pads, ends = len(p.pads), by.copy()
    ends[:pads] -= 0.5 * h * cross(w) @ by[:pads]
    found = by.reshape(-1, by.shape[-1]).T @ (after.slope @ ends).reshape(-1, by.shape[-1])
    of_box = 0.5 * np.sum(cross(after.force[:pads]) @ by[:pads], axis=0)
    of_others = of_box.T.copy()
    turned_back = cross(after.force[pads:] @ mean.turned[0])
    of_others[3:6] = 0.5 * np.sum(cross(p.corners) @ turned_back, axis=0)
    found[3:6] += of_box
    found[:, 3:6] += of_others
    return h * found
