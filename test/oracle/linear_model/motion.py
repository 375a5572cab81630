# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A damped mass under a force held for a time, by the matrix exponential."""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from pmwvc_core.numeric import Array


class Motion(NamedTuple):
    """Coefficients of x and xd at the end in xd at the start and the force, a row per run."""

    xd_x: Array
    f_x: Array
    xd_xd: Array
    f_xd: Array


def motion(mass: Array, damping: Array, time_s: float) -> Motion:
    """Return the motions of masses [kg] with dampers [N s/m], ``(runs, 1)``."""
    rows = []
    for m, b in zip(*map(np.ravel, np.broadcast_arrays(mass, damping)), strict=True):
        whole = expm(time_s * np.array([[0, 1, 0], [0, -b / m, 1 / m], [0, 0, 0]]))
        rows.append([whole[0, 1], whole[0, 2], whole[1, 1], whole[1, 2]])
    return Motion(*(np.array(rows).T[..., np.newaxis]))
