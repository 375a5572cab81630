# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The slope of a black box, learned from its own answers, one user at a time.

The port decodes with a line through the last force F- at the last position x-::

    F' = F- + K^ (x - x-),   x = position + w xd,   hence   F' = F0 + G xd,   G = w K^

K^ is a symmetric positive semidefinite matrix, a slowly decaying maximum of the secant of force
over position. With dx = x - x-, dF = F - F- and s = (dF - K^ dx) . dx::

    s > 0:  K^ += s p p^T/(p . dx)^2,   p = dF - K^ dx, or dx where p is nearly across
    s < 0:  K^ -= c (K^ dx)(K^ dx)^T/(dx . K^ dx),   c = min(0.1, -s/(dx . K^ dx))

so that K^ has the measured secant along dx, or loses a tenth of its own there per step. Both
keep it semidefinite. A step much shorter than recent ones is not used (a damper's force turns
round while its position stands still). A step into a one-sided contact that is stiffer than known
measures less than its slope, as it begins outside: seven times that is taken, so that the next
step ends inside as well and measures the slope itself.

Up to |K^| T = b/2 the line is not used and F' = F-: decoding late is passive there (2B <= 0.35 b),
and a slope that varies costs energy of its own.

An environment in which a user moved without force is taken as one-sided: its force does not change
its sign, and where it ended there is a face, until a force expected there does not come.

Equations: docs/theory.md 5.3, 5.5.
"""

from typing import NamedTuple

import numpy as np

from pmwvc_core.numeric import Array, Flags
from pmwvc_core.wave.impedance import times

DECAY = 0.9  # of a slope per step that measures less
SHORT = 0.3  # length of a step that is too short, relative to recent ones
LEAST_M = 1e-12
NEARLY_ACROSS = 0.5  # cosine
SOFT = 0.5  # K T/b up to which the force of the step before will do
LEAP = 7.0  # slope taken where a contact begins, over what the step measured
LARGEST = 100.0  # G relative to b


class Line(NamedTuple):
    """The force that a user expects: F0 + G xd, not across its own direction."""

    force: Array  # (users, ..., dof) [N] F0
    slope: Array  # (users, ..., dof, dof) [N s/m] G
    along: Array  # (users, ..., dof) direction that the force keeps; zero: any


class Secant:
    """The slope learned of the environment at each user's avatar.

    Parameters
    ----------
    scale
        b/T, smallest wave impedance over the period, ``(users, ..., 1)`` [N/m].
    shape
        Of one user's signal.
    """

    def __init__(self, scale: Array, shape: tuple[int, ...]) -> None:
        users = (len(scale), *shape)
        self._scale = scale
        self._position = np.zeros(users)
        self._force = np.zeros(users)
        self._slope = np.zeros((*users, shape[-1]))
        self._longest = np.zeros((*users[:-1], 1))  # [m] recent step, decaying
        self._one_sided = np.zeros((*users[:-1], 1), dtype=bool)
        # Last position, force and its direction with contact; direction zero: no face is known.
        self._face = np.zeros(users), np.zeros(users), np.zeros(users)
        self._expected = np.zeros((*users[:-1], 1), dtype=bool)

    def join(self, user: int, position: Array) -> None:
        """Begin to learn anew."""
        for state in (self._force, self._slope, self._longest, *self._face):
            state[user] = 0.0
        self._one_sided[user] = False
        self._position[user] = position

    def line(self, position: Array, weight: float) -> Line:
        """Return what to expect where the avatars would be without their new velocity [m]."""
        touching = _touching(self._force)
        last, force, along = self._face
        last = np.where(touching, self._position, last)
        rise = times(self._slope, position - last)
        ahead = _dot(along, force + times(self._slope, position - last))
        slope = np.where(touching[..., np.newaxis], self._slope, self._across_face(along))
        found = np.where(touching, self._force + rise, ahead * along)
        kept = np.where(self._one_sided, _direction(np.where(touching, self._force, along)), 0.0)
        stiff = self.ratio > 0.0
        return Line(
            np.where(stiff, found, self._force),
            np.where(stiff[..., np.newaxis], weight * slope, 0.0),
            np.where(stiff, kept, 0.0),
        )

    def _across_face(self, along: Array) -> Array:
        """Return the slope along the normal of a face alone."""
        stiffness = _dot(along, times(self._slope, along))
        return np.asarray(stiffness[..., np.newaxis] * along[..., :, None] * along[..., None, :])

    def expect(self, expected: Flags) -> None:
        """Note whose avatar was decoded with a force, ``(users, ..., 1)`` of bool."""
        self._expected = expected

    def learn(self, position: Array, force: Array, good: Flags) -> None:
        """Take in the forces [N] at the avatars' positions [m], where they can be used."""
        position = np.where(good, position, self._position)
        force = np.where(good, force, self._force)
        step, rise = position - self._position, force - self._force
        length = np.linalg.norm(step, axis=-1, keepdims=True)
        before, now = _touching(self._force), _touching(force)
        self._one_sided |= ~(before | now) & (length > 0.0)
        self._longest = np.maximum(DECAY * self._longest, np.where(before & now, length, 0.0))
        informative = (before | now) & (length > np.maximum(SHORT * self._longest, LEAST_M))
        safe = np.where(informative, length, 1.0)
        hits = now & ~before & self._one_sided
        self._raise(step / safe, rise / safe, informative, hits)
        self._decay(step / safe, rise / safe, informative & before & now)
        gone = self._expected & ~now & ~before
        kept = (self._position, self._force, _direction(self._force))
        new = (position, force, _direction(force))
        face = []
        for old, last, present in zip(self._face, kept, new, strict=True):
            found = np.where(now, present, np.where(before, last, old))
            face.append(np.where(gone, 0.0, found))
        self._face = (face[0], face[1], face[2])
        self._position, self._force = position, force

    @property
    def ratio(self) -> Array:
        """Return |K^| T/b of the slopes in use, zero where decoding late will do."""
        return np.where(self.learned > SOFT, self.learned, 0.0)

    @property
    def learned(self) -> Array:
        """Return |K^| T/b of all slopes; where a contact chatters, (K T + 2B)/b."""
        length = np.linalg.norm(self._slope, axis=(-2, -1))[..., np.newaxis]
        return np.asarray(length / self._scale)

    def _raise(self, course: Array, secant: Array, informative: Flags, hits: Flags) -> None:
        own = _dot(course, times(self._slope, course))
        missing = secant - times(self._slope, course)
        short = _dot(missing, course)
        across = short < NEARLY_ACROSS * np.linalg.norm(missing, axis=-1, keepdims=True)
        along = np.where(across, course, missing)
        onto = _dot(along, course)
        measured = own + short
        hits = hits & (measured > SOFT * self._scale)
        wanted = np.where(hits, LEAP * measured, measured)
        most = np.minimum(wanted, LARGEST * self._scale) - own
        raised = informative & (short > 0.0) & (most > 0.0)
        along = np.where(raised, along / np.where(raised, onto, 1.0), 0.0)
        gain = most * along
        self._slope = self._slope + gain[..., :, None] * along[..., None, :]

    def _decay(self, course: Array, secant: Array, informative: Flags) -> None:
        pull = times(self._slope, course)
        own, excess = _dot(pull, course), _dot(pull - secant, course)
        falls = informative & (excess > 0.0) & (own > 0.0)
        safe = np.where(falls, own, 1.0)
        gain = np.where(falls, np.minimum(1.0 - DECAY, excess / safe), 0.0) * pull
        self._slope = self._slope - gain[..., :, None] * (pull / safe)[..., None, :]


def decoded(line: Line, drive: Array, impedance: Array) -> tuple[Array, Flags]:
    """Return xd [m/s] and who was decoded with a force, for B sqrt(2/B) u of every user [N].

    ``impedance`` is B as matrices ``(users, ..., dof, dof)``.
    """
    free = _solve(impedance, drive)
    met = _solve(impedance + line.slope, drive - line.force)
    force = line.force + times(line.slope, met)
    pushes = (_dot(line.along, force) >= 0.0) & _touching(force)
    return np.where(pushes, met, free), pushes


def _solve(matrix: Array, right: Array) -> Array:
    if right.shape[-1] == 1:
        return np.asarray(right / matrix[..., 0])
    return np.asarray(np.linalg.solve(matrix, right[..., np.newaxis])[..., 0])


def _touching(force: Array) -> Flags:
    return np.asarray(np.any(force != 0.0, axis=-1, keepdims=True))


def _direction(force: Array) -> Array:
    length = np.linalg.norm(force, axis=-1, keepdims=True)
    return np.asarray(force / np.where(length > 0.0, length, 1.0))


def _dot(left: Array, right: Array) -> Array:
    return np.asarray(np.sum(left * right, axis=-1, keepdims=True))
