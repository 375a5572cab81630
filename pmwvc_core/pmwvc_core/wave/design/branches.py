# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Passivity of two branches of a wave together (App. D).

A low-pass branch goes to the environment, a share s of a high-pass branch is fed back at once:
v = R H_LP u + s H_HP u, with R the reflection of the environment; passive means |R| <= 1.

====================  ============================================================================
in phase              |H_LP + s H_HP|^2 <= 1: R = 1. App. D Eq. 14; necessary, not sufficient
any environment       |H_LP| + s |H_HP| <= 1 at all frequencies: any R(z), since R may turn the
                      first term into the direction of the second; then sum u^2 - v^2 >= 0 at every
                      tick, as all of it is causal
switching             any passive thing at all (a contact that opens, a rate drop): it may move
                      the energy of one frequency to another, where it meets the high branch
====================  ============================================================================

Of the last, with l the gains of the images that a rate drop folds onto one another (one image: no
rate drop) and D their shares s |H_HP|: for every x, |R l.x + D x|^2 <= (1 + c)|l.x|^2 +
(1 + 1/c)|D x|^2 for all c > 0, so that

    gain^2 = min over c of max over frequency of eig[(1 + c) l l^T + (1 + 1/c) D^2].

It is reached without a rate drop (the bound is concave in how energy is spread over frequency, and
convex in c); with one it may be too large. As s H_HP = s at high and |H_LP| = 1 at low frequency,
it is at least sqrt(1 + s^2): no such pair is passive against everything.

Not here: how branches are chosen (:mod:`.velocity_filter_design`).

Equations: docs/theory.md 7.4, 7.5, 7.6, 8.6.
"""

from typing import TypedDict

import numpy as np

from pmwvc_core.numeric import Array, Complex
from pmwvc_core.wave.design.aliasing import minimum_between

TOLERANCE = 1e-9  # of an amplitude: what rounding may add to 1


class Margins(TypedDict):
    """The margins of the first two conditions."""

    frequency_hz: Array  # (points,)
    in_phase: Array  # (points,) |H_LP + s H_HP|^2, App. D Eq. 14
    any_environment: Array  # (points,) |H_LP| + s |H_HP|
    in_phase_margin: float  # 1 less the largest value; negative: not met
    in_phase_worst_hz: float
    any_environment_margin: float
    any_environment_worst_hz: float


def margins(low: Complex, high: Complex, frequency_hz: Array, *, share: float = 0.5) -> Margins:
    """Return both conditions on a low-pass branch and a share s of a high-pass branch: frequency
    responses ``(points,)``, ``high`` zero for a channel without that branch.
    """
    in_phase = np.abs(low + share * high) ** 2
    any_environment = np.abs(low) + share * np.abs(high)
    worst, worst_any = int(np.argmax(in_phase)), int(np.argmax(any_environment))
    return {
        "frequency_hz": frequency_hz,
        "in_phase": in_phase,
        "any_environment": any_environment,
        "in_phase_margin": 1.0 - float(in_phase[worst]),
        "in_phase_worst_hz": float(frequency_hz[worst]),
        "any_environment_margin": 1.0 - float(any_environment[worst_any]),
        "any_environment_worst_hz": float(frequency_hz[worst_any]),
    }


def switching_gain(low: Array, fed_back: Array) -> float:
    """Return how much longer the returning wave can be than the outgoing one, whatever reflects,
    from |H_LP| and s |H_HP| at the images of every frequency ``(points, images)``.
    """
    size = low.shape[-1]
    outer = low[:, :, np.newaxis] * low[:, np.newaxis, :]
    squares = fed_back[:, :, np.newaxis] ** 2 * np.eye(size)

    def worst(log_c: float) -> float:
        c = np.exp(log_c)
        matrices = (1.0 + c) * outer + (1.0 + 1.0 / c) * squares
        return float(np.linalg.eigvalsh(matrices)[:, -1].max())

    return float(np.sqrt(minimum_between(worst, -14.0, 14.0, within=1e-5)[1]))
