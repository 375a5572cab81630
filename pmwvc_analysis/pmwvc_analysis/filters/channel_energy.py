# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy of the parts of a channel over time: rate drop, holds, computational delay.

Each function takes the signals of one part and returns what went in, what came out and what is
left, instant by instant [J]. A part is passive when nothing it has left is ever below zero.

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


def sine_deficit(
    frequency_hz: float,
    *,
    rate_drop: int,
    tick_s: float = 1e-3,
    amplitude: float = 1.0,
    phases: int = 360,
) -> dict[str, float]:
    """Return how far below zero a decimator gets on the way, at the worst phase of a sine.

    The sine is sent without a filter. Below half the packet rate nothing is aliased and the energy
    balances in the end, yet not at every instant: the packets' |u|^2 swings at the distance of 2 f
    from the packet rate, and a packet counts for a whole frame at its start.

    Returns
    -------
    dict
        ``minimum_j``, ``time_s`` and ``phase_rad`` of the minimum, over two swings.
    """
    packet_hz = 1.0 / (rate_drop * tick_s)
    beat_hz = abs(2.0 * frequency_hz - packet_hz * round(2.0 * frequency_hz / packet_hz))
    slowest_hz = max(min(beat_hz, 2.0 * frequency_hz), 0.01)
    ticks = int(np.ceil(2.0 / slowest_hz / tick_s)) + 2 * rate_drop
    time_s = np.arange(ticks) * tick_s
    best = {"minimum_j": 0.0, "time_s": 0.0, "phase_rad": 0.0}
    for phase in np.pi * np.arange(phases) / phases:  # |u|^2 has period pi
        wave = amplitude * np.sin(2.0 * np.pi * frequency_hz * time_s + phase)
        left = rate_drop_energy(wave, rate_drop=rate_drop, tick_s=tick_s)["left_j"]
        lowest = int(np.argmin(left))
        if left[lowest] < best["minimum_j"]:
            best = {
                "minimum_j": float(left[lowest]),
                "time_s": float(time_s[lowest]),
                "phase_rad": float(phase),
            }
    return best


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


def first_order_hold_left(packets: Array, *, rate_drop: int, tick_s: float) -> Array:
    """Return the closed form of what the delayed hold has left at each frame end [J]."""
    packets, ratio = np.asarray(packets, dtype=float), rate_drop
    steps = np.cumsum(np.diff(packets, prepend=0.0) ** 2)
    scale = tick_s * (ratio - 1) / (12.0 * ratio)
    return scale * ((ratio + 1) * steps + 3.0 * ratio * packets**2)


def delay_energy(force: Array, *, impedance: float, period_s: float) -> dict[str, Array]:
    """Return what decoding with the force of the previous step does to the energy (App. C Eq. 12).

    With xd(n) = sqrt(2/b) u(n) - F(n-1)/b the port takes in (u^2 - v^2)/2 = F xd + d(n), where
    d(n) = [F(n) F(n-1) - F(n)^2]/b is less than the environment gets. Summed, with F(-1) = 0,

        dE = (T/b) sum [F(n) F(n-1) - F(n)^2] = -(T/2b) [sum (F(n) - F(n-1))^2 + F(N)^2] <= 0.

    Parameters
    ----------
    force
        F(n) ``(step,)`` [N].

    Returns
    -------
    dict
        ``power_w`` d(n) of each step, ``energy_j`` its running sum, ``closed_j`` the closed form.
    """
    force = np.asarray(force, dtype=float)
    before = np.concatenate([[0.0], force[:-1]])
    power = (force * before - force**2) / impedance
    steps = np.cumsum((force - before) ** 2)
    return {
        "power_w": power,
        "energy_j": np.cumsum(power) * period_s,
        "closed_j": -0.5 * period_s / impedance * (steps + force**2),
    }
