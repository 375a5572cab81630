# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The passivity of a wave's two branches behind a velocity filter (App. D) or a bank.

A low-pass branch goes to the environment and a share s of a high-pass branch is fed back at once:
v = R H_LP u + s H_HP u, with R the reflection of the environment; passive means |R| <= 1.

====================  ============================================================================
in phase              |H_LP + s H_HP|^2 <= 1: R = 1. App. D Eq. 14; necessary, not sufficient
any environment       |H_LP| + s |H_HP| <= 1 at all frequencies: any R(z), since R may turn the
                      first term into the direction of the second; then sum u^2 - v^2 >= 0 at every
                      tick, as all of it is causal
switching             any passive thing at all (a contact that opens, a rate drop): it may move
                      the energy of one frequency to another, where it meets the high branch
====================  ============================================================================

Equations: docs/theory.md 7.4, 7.5, 7.6, 8.6.
"""

from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from pmwvc_core.numeric import Array, Complex
from pmwvc_core.params import MasterParams
from pmwvc_core.wave.filter_design import response, sections_response
from pmwvc_core.wave.velocity_filter_design import passing


def margins(
    low: Complex, high: Complex, frequency_hz: Array, *, share: float = 0.5
) -> dict[str, Any]:
    """Return ``in_phase`` |H_LP + s H_HP|^2 and ``any_environment`` |H_LP| + s |H_HP|, with the
    ``frequency_hz`` given ``(points,)``: frequency responses, ``high`` zero for a channel without
    that branch. Of each, ``.._margin`` is 1 less the largest value (negative: not met), and
    ``.._worst_hz`` where that is.
    """
    curves = {
        "in_phase": np.abs(low + share * high) ** 2,
        "any_environment": np.abs(low) + share * np.abs(high),
    }
    found: dict[str, Any] = {"frequency_hz": frequency_hz, **curves}
    for name, curve in curves.items():
        worst = int(np.argmax(curve))
        found[f"{name}_margin"] = 1.0 - float(curve[worst])
        found[f"{name}_worst_hz"] = float(frequency_hz[worst])
    return found


def switching_gain(low: Array, fed_back: Array) -> float:
    """Return how much longer the returning wave can be than the outgoing one, whatever reflects,
    from l = |H_LP| and the diagonal D of s |H_HP| at the images that a rate drop folds onto one
    another ``(points, images)``.

    For every x, |R l.x + D x|^2 <= (1 + c)|l.x|^2 + (1 + 1/c)|D x|^2 for all c > 0, so that

        gain^2 = min over c of max over frequency of eig[(1 + c) l l^T + (1 + 1/c) D^2].

    It is reached without a rate drop; with one it may be too large. At least it is sqrt(1 + s^2):
    s H_HP = s at high and |H_LP| = 1 at low frequency, so no such pair is passive against
    everything.
    """
    size = low.shape[-1]
    outer = low[:, :, np.newaxis] * low[:, np.newaxis, :]
    squares = fed_back[:, :, np.newaxis] ** 2 * np.eye(size)

    def worst(log_c: float) -> float:
        c = np.exp(log_c)
        matrices = (1.0 + c) * outer + (1.0 + 1.0 / c) * squares
        return float(np.linalg.eigvalsh(matrices)[:, -1].max())

    return float(np.sqrt(minimize_scalar(worst, bounds=(-14.0, 14.0), method="bounded").fun))


def branches(params: MasterParams, frequency_hz: Array) -> tuple[Complex, Complex]:
    """Return the responses of the branch to the environment and back, and of that fed back (all
    of it, not the share), for parameters with ``alpha`` or ``cutoff_hz``.
    """
    tick_s, own = params.tick_s, params.velocity_filter
    angle = 2.0 * np.pi * tick_s * np.asarray(frequency_hz, dtype=float)
    low = response(params.filter, frequency_hz, tick_s=tick_s, rate_drop=params.rate_drop)
    high = sections_response(passing(params, "high"), angle)
    if not own.splits:
        return low, high
    pair = sections_response(passing(params, "low"), angle)
    return low * pair**2, high**2
