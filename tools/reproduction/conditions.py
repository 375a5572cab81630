# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of claims that stand in equations and not in a figure."""

import numpy as np

from pmwvc_analysis.models.linearize import build, spectral_radius
from pmwvc_core.numeric import Array
from pmwvc_core.params import BankParams
from pmwvc_core.wave.filter_design import bank_filters, sections_response
from reproduction.branches import switching_gain
from reproduction.channel_energy import hold_energy, rate_drop_energy
from reproduction.figure import Values
from reproduction.scenarios import scenario

ANGLE = np.linspace(1e-4, np.pi, 20_001)  # [rad/sample]


def band_limited_balance(rate_drop: int) -> Values:
    """Return the lowest and the last energy balance of a rate drop without aliasing (A Eq. 13),
    over the energy of the wave, at the ends of frames.

    The wave is a sinc squared, whose spectrum ends at pi/M.
    """
    frames = 4000
    ticks = np.arange(-frames * rate_drop, frames * rate_drop)
    wave = np.sinc(ticks / (2.0 * rate_drop)) ** 2
    left = rate_drop_energy(wave, rate_drop=rate_drop, tick_s=1.0)
    ends = left["left_j"][rate_drop - 1 :: rate_drop]
    whole = float(left["in_j"][-1])
    return {"lowest": float(ends.min()) / whole, "last": float(ends[-1]) / whole}


def reflections(*, impedance: float, mass: float, stiffness: float, period_s: float) -> Values:
    """Return the largest gains of both ends of A 4.2 over frequency: the spring with its loop
    solved (Eq. 20, 21), and the device without damping under a force held for a tick of 1 ms.
    """
    z = np.exp(1j * ANGLE)
    spring = 0.5 * stiffness * period_s * (z + 1.0) / (z - 1.0)
    server = np.abs((impedance - spring) / (impedance + spring))
    inertia = mass / 1e-3 * (z - 1.0)
    device = np.abs((impedance - inertia) / (impedance + inertia))
    return {"server": float(np.abs(server - 1.0).max()), "device": float(device.max())}


def hold_balance(rate_drop: int) -> float:
    """Return the lowest energy balance that the delayed first-order hold has at the end of any
    frame, over what went in until then (B, Eqs. 43 to 54), over 200 random waves of 50 frames.
    """
    rng = np.random.default_rng(1)
    lowest = np.inf
    for _ in range(200):
        found = hold_energy(rng.normal(size=50), rate_drop=rate_drop, tick_s=1e-3)
        lowest = min(lowest, float((found["left_j"] / found["in_j"]).min()))
    return lowest


def radii_over_delay(model: Values, delays_s: list[float]) -> Values:
    """Return the spectral radius of a model for each delay each way."""
    return {
        f"spectral_radius_delay_{1e3 * delay:g}_ms": spectral_radius(
            build(scenario({**model, "link.delay_s": delay}, users=1))
        )
        for delay in delays_s
    }


def bank_gains(name: str, anti_aliasing: Array, bank: BankParams) -> Values:
    """Return the largest |LP1| + |LP2| |HP|, which any linear environment and local model need to
    be at most 1, and the gain that a contact that opens and closes may find.
    """
    filters = bank_filters(bank, tick_s=1e-3)
    low = np.abs(sections_response(anti_aliasing, ANGLE))
    high = np.abs(
        sections_response(filters.high_up, ANGLE) * sections_response(filters.high_down, ANGLE)
    )
    coarse = slice(None, None, 50)
    switching = switching_gain(low[coarse, np.newaxis], high[coarse, np.newaxis])
    return {
        f"bank_{name}": float((low + high).max()),
        f"bank_switching_{name}": switching,
    }
