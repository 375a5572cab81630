# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy of rate drop and hold over time, from their signals.

Each function returns the energy that went in, the energy that came out and their difference,
instant by instant [J]. A part is passive if the difference is never below zero.

Equations: docs/theory.md 3.2, 14.1, 14.2.
"""

from typing import TypedDict

import numpy as np

from pmwvc_core.numeric import Array


class Account(TypedDict):
    """Running energies of one part; ``left_j`` = in less out."""

    in_j: Array
    out_j: Array
    left_j: Array


class Aliasing(TypedDict):
    """Energies of the counterexample, summed and in closed form [J]."""

    in_j: float
    out_j: float
    left_j: float
    closed_in_j: float
    closed_out_j: float
    closed_left_j: float


def _account(energy_in: Array, energy_out: Array) -> Account:
    return {"in_j": energy_in, "out_j": energy_out, "left_j": energy_in - energy_out}


def rate_drop_energy(wave: Array, *, rate_drop: int, tick_s: float) -> Account:
    """Return the account of a plain decimator after each tick (App. A Eq. 9).

    Parameters
    ----------
    wave
        ``(..., tick)`` [sqrt(W)]; ticks 0, M, 2M... are sent, each for a whole frame.

    Returns
    -------
    Account
        ``(..., tick)``. A packet counts with its whole frame at the tick it samples.
    """
    power = 0.5 * np.asarray(wave, dtype=float) ** 2
    sent = np.zeros_like(power)
    sent[..., ::rate_drop] = power[..., ::rate_drop] * rate_drop
    return _account(np.cumsum(power, axis=-1) * tick_s, np.cumsum(sent, axis=-1) * tick_s)


def aliasing_example(
    edge_rad: float,
    *,
    shift: int = 0,
    tick_s: float = 1e-3,
    height: float = 1.0,
    ticks: int = 400_000,
) -> Aliasing:
    """Return the counterexample of App. A Eqs. 14-18: M = 2, a flat spectrum beyond pi/2.

    |U| = alpha for |Omega| < Om, zero phase, is u(k) = alpha sin(Om k)/(pi k). With the 1/2 of
    Eq. 9, which Eqs. 14 to 18 leave out::

        in   T alpha^2 Om / (2 pi)
        out  T alpha^2 (3 Om - pi) / (2 pi)
        left -T alpha^2 (2 Om - pi) / (2 pi)

    Shifted by one tick, the odd values are sent instead of the even ones; both together carry
    twice the energy of the wave, so what was given out is now taken in: the same with the other
    sign.

    Parameters
    ----------
    edge_rad
        Om, above pi/2 and up to pi [rad per tick].
    shift
        By how many ticks the wave comes early.
    ticks
        Values summed on either side of the middle; the rest is of the order 1/ticks.
    """
    if not np.pi / 2 <= edge_rad <= np.pi:
        raise ValueError(f"edge_rad = {edge_rad}: must be between pi/2 and pi")
    k = np.arange(-ticks, ticks + 1)  # ``ticks`` even: the first value is sent
    wave = height * edge_rad / np.pi * np.sinc(edge_rad / np.pi * (k + shift))
    found = rate_drop_energy(wave, rate_drop=2, tick_s=tick_s)
    unit = 0.5 * tick_s * height**2 / np.pi
    sign = -1.0 if shift % 2 == 0 else 1.0
    left = sign * unit * (2.0 * edge_rad - np.pi)
    return {
        "in_j": float(found["in_j"][-1]),
        "out_j": float(found["out_j"][-1]),
        "left_j": float(found["left_j"][-1]),
        "closed_in_j": unit * edge_rad,
        "closed_out_j": unit * edge_rad - left,
        "closed_left_j": left,
    }


def hold_energy(packets: Array, *, rate_drop: int, tick_s: float, hold: str = "foh") -> Account:
    """Return the account of the hold at the end of each frame (App. B, Eqs. 43-54).

    Zero-order: nothing is ever left. Delayed first-order hold, v(k) = v_{i-1} + (v_i - v_{i-1})
    j/M with v_{-1} = 0: summing |v|^2 over each frame gives exactly

        left = T_c (M-1)/(12 M) [(M+1) sum (v_j - v_{j-1})^2 + 3 M v_i^2] >= 0.

    Parameters
    ----------
    packets
        ``(frame,)`` [sqrt(W)], one per frame, none missing.
    """
    packets = np.asarray(packets, dtype=float)
    share = np.arange(1, rate_drop + 1) / rate_drop if hold == "foh" else np.ones(rate_drop)
    before = np.concatenate([[0.0], packets[:-1]])
    ramps = before[:, np.newaxis] + np.multiply.outer(packets - before, share)
    energy_in = np.cumsum(0.5 * packets**2) * rate_drop * tick_s
    return _account(energy_in, np.cumsum(0.5 * np.sum(ramps**2, axis=1)) * tick_s)
