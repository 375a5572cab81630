# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The power of a pair of waves, from its definition."""

import numpy as np


def power(u, v):
    """Return the power that runs towards the server, (|u|^2 - |v|^2)/2 [W], one per run."""
    return (squared(u) - squared(v)) / 2


def squared(wave):
    """Return the squared length: of a number, else of the last axis, which stays."""
    return wave**2 if np.ndim(wave) == 0 else np.sum(np.square(wave), axis=-1, keepdims=True)
