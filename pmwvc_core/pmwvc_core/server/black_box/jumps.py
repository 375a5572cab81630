# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A force that jumps while hardly anything moved: a fault of the environment.

A physics engine that begins anew puts bodies elsewhere in one step; an avatar that stands still
then is inside one of them. With s the longest way in this step of any avatar, or of the object by
the velocity that the environment showed before (fading over ``MEMORY_S``, since a body goes on
moving), a change of force since the last one that was used, n steps ago, is accepted up to

    |F - F-| <= 100 (b/T) s + b n ``KICK_M_S``

The first term is the stiffest contact that the port can learn (``secant.LARGEST``): no impact that
an avatar or a pushed object makes is a fault. By the second a force that stays is accepted soon.

Equations: docs/theory.md 5.13.
"""

import numpy as np

from pmwvc_core.numeric import Array, Flags
from pmwvc_core.server.black_box.secant import LARGEST

KICK_M_S = 0.4  # change of force over b
MEMORY_S = 0.5


class Jumps:
    """Tells the forces that can be used from those that jumped.

    Parameters
    ----------
    impedance
        Smallest wave impedance of each user ``(users, ..., 1)`` [N s/m].
    shape
        Of one user's signal.
    period
        Time step T [s].
    """

    def __init__(self, impedance: Array, shape: tuple[int, ...], period: float) -> None:
        users = (len(impedance), *shape)
        self._stiffest = LARGEST * impedance / period
        self._kick = KICK_M_S * impedance
        self._kept = max(1.0 - period / MEMORY_S, 0.0)
        self._position, self._force = np.zeros(users), np.zeros(users)
        self._way = np.zeros((*shape[:-1], 1))  # [m]
        self._steps = np.zeros((*users[:-1], 1))  # since a force was used

    def join(self, user: int, position: Array) -> None:
        """Begin without force."""
        self._force[user] = self._steps[user] = 0.0
        self._position[user] = position

    def explained(self, position: Array, force: Array, good: Flags, object_m: Array) -> Flags:
        """Tell which forces [N] at the avatars [m] can be used, beside those that are not good.

        ``object_m`` is the way of the object ``(..., 1)`` [m].
        """
        moved = np.linalg.norm(position - self._position, axis=-1, keepdims=True).max(axis=0)
        self._way = np.maximum(np.maximum(moved, object_m), self._kept * self._way)
        self._steps = self._steps + 1.0
        change = np.linalg.norm(force - self._force, axis=-1, keepdims=True)
        found = change <= self._stiffest * self._way + self._kick * self._steps
        used = good & found
        self._position = position
        self._force = np.where(used, force, self._force)
        self._steps = np.where(used, 0.0, self._steps)
        return np.asarray(found)
