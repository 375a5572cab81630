# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Contacts at points with friction, whose energy balances in every step, whatever their motion.

A point has the depth d and a bristle e along the surface; a step h moves it by D, along the
outward normal n and along the surface::

    s = -n . D,   t = D + s n,   d1 = d0 + s,   p = max(d, 0)
    F = max((k/2 (p1^2 - p0^2) + B (p1 - p0) s/h)/s, 0)              pressing; k p0 where s = 0
    f = k (e0 + t/2) + B t/h, shortened to |f| <= mu F                along the surface
    e1 from f = k (e0 + e1)/2 + B (e1 - e0)/h;   e1 = 0 where mu F = 0

The force of the point on the surface is phi = f - F n, and

    phi . D = change of k (p^2 + |e|^2)/2 + heat,   heat >= 0

as B (p1 - p0) s >= 0, what a force of zero does not take up is lost, and the slip t - (e1 - e0) is
along f. Equations: docs/theory.md 5.17.
"""

from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenes.turning import ONE


class Points(NamedTuple):
    """Points at the beginning of a step: outward normals ``(n, 3)``, depths ``(n,)`` [m], bristles
    ``(n, 3)`` [m], k [N/m], B [N s/m] and mu, each ``(n,)``, and which can touch.
    """

    normal: Array
    depth: Array
    bristle: Array
    stiffness: Array
    damping: Array
    friction: Array
    can_touch: Flags


class Pressed(NamedTuple):
    """Forces of points on the surface ``(n, 3)`` [N], their slopes by the motion ``(n, 3, 3)``
    [N/m], forces along the normals ``(n,)`` [N] and bristles ``(n, 3)`` [m].
    """

    force: Array
    slope: Array
    pressing: Array
    bristle: Array


def pressed(p: Points, motion: Array, h: float, bound: Array | None = None) -> Pressed:
    """Return what a step of h [s] with motions ``(n, 3)`` [m] does at every point. With a bound
    ``(n,)`` [N] in the place of mu F the forces have a potential; the balance is the same.
    """
    n, k, damping = p.normal, p.stiffness, p.damping
    s = -np.sum(n * motion, axis=-1)
    pressing, rise = _along_normal(p, s, h)
    t = motion + s[:, None] * n
    c = 0.5 * k + damping / h
    wanted = k[:, None] * p.bristle + c[:, None] * t
    most, follows = (p.friction * pressing, p.friction) if bound is None else (bound, 0.0 * bound)
    size = np.linalg.norm(wanted, axis=-1)
    slips = size > most
    part = np.where(slips, most / np.where(slips, size, 1.0), 1.0)
    f = part[:, None] * wanted
    stays = (f + (damping / h - 0.5 * k)[:, None] * p.bristle) / np.where(c > 0.0, c, 1.0)[:, None]
    bristle = np.where(most[:, None] > 0.0, stays, 0.0)
    force = f - pressing[:, None] * n
    way = wanted / np.where(size > 0.0, size, 1.0)[:, None] * slips[:, None]
    slope = (part * c)[:, None, None] * (ONE - _outer(n, n) - _outer(way, way))
    slope += _outer(rise[:, None] * (n - follows[:, None] * way), n)
    return Pressed(force, slope, pressing, bristle)


def _along_normal(p: Points, s: Array, h: float) -> tuple[Array, Array]:
    """Return the forces along the normals [N], and their slopes by s [N/m]."""
    k, before = p.stiffness, np.where(p.can_touch, np.maximum(p.depth, 0.0), 0.0)
    after = np.where(p.can_touch, np.maximum(p.depth + s, 0.0), 0.0)
    inside, way = (before > 0.0) & (after > 0.0), np.where(s != 0.0, s, np.inf)
    share = np.where(inside, 1.0, (after - before) / way)  # of the step in which it is inside
    force = 0.5 * k * (before + after) * share + p.damping / h * (after - before)
    touching = (after > 0.0) * 1.0
    of_share = np.where(inside, 0.0, (touching - share) / way)
    rise = 0.5 * k * (touching * share + (before + after) * of_share) + p.damping / h * touching
    return np.maximum(force, 0.0), np.where(force > 0.0, rise, 0.0)


def stored_j(p: Points) -> float:
    """Return the energy in springs and bristles [J]."""
    inside = np.where(p.can_touch, np.maximum(p.depth, 0.0), 0.0)
    return float(0.5 * np.sum(p.stiffness * (inside**2 + np.sum(p.bristle**2, axis=-1))))


def _outer(a: Array, b: Array) -> Array:
    return np.asarray(a[:, :, None] * b[:, None, :])
