# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The stability of one scenario as plain data and in sentences."""

import math
from typing import Any

import numpy as np

from pmwvc_analysis.models import rigid, stability
from pmwvc_analysis.models.linear import notes_of
from pmwvc_analysis.models.multirate import transitions
from pmwvc_core.plural import count
from pmwvc_core.simulation.scenario import Scenario


def answer(
    scenario: Scenario, *, live: bool = False, bound: float = stability.BOUND
) -> dict[str, Any]:
    """Return what the exact model says of a scenario.

    Returns
    -------
    dict
        ``spectral_radius`` per hyperframe of ``hyperframe_ticks``, ``stable``, ``k_max`` [N/m]
        (None: nothing up to ``k_max_bound`` is unstable), ``islands`` (stable ranges above
        ``k_max``), ``rigid_body_modes`` (taken out), ``states`` (their number, with those),
        ``slowest`` (``frequency_hz`` and growth ``per_second`` of the largest eigenvalue),
        ``notes``.
    """
    model = transitions(scenario, live=live)
    left = rigid.quotient(model.matrices, model.rigid)[0]
    values = np.linalg.eigvals(left) if len(left) else np.zeros(1)
    largest = complex(values[np.argmax(np.abs(values))])
    radius = float(np.abs(largest))
    limit = stability.k_max(scenario, live=live, bound=bound)
    hyperframe_s = model.ticks * scenario.tick_s
    return {
        "scenario": scenario.name,
        "live": live,
        "spectral_radius": radius,
        "stable": stability.stable(radius),
        "k_max": limit.first,
        "k_max_bound": limit.bound,
        "islands": [list(island) for island in limit.islands],
        "rigid_body_modes": rigid.count(model.rigid),
        "states": len(model.states),
        "hyperframe_ticks": model.ticks,
        "slowest": {
            "frequency_hz": abs(math.atan2(largest.imag, largest.real))
            / (2.0 * math.pi * hyperframe_s),
            "per_second": math.log(radius) / hyperframe_s if radius > 0.0 else None,
        },
        "notes": notes_of(scenario),
    }


def sentences(found: dict[str, Any]) -> list[str]:
    """Return an answer in words."""
    word = "stable" if found["stable"] else "NOT stable"
    slowest = found["slowest"]
    rate = slowest["per_second"]
    lines = [f"{found['scenario']}: {word}, spectral radius {found['spectral_radius']:.6f}"]
    if rate is not None:
        course = "grows" if rate > 0.0 else "decays"
        lines.append(
            f"  slowest mode: {slowest['frequency_hz']:.2f} Hz, {course}, "
            f"time constant {1.0 / abs(rate):.3g} s"
            if rate
            else f"  slowest mode: {slowest['frequency_hz']:.2f} Hz, neither grows nor decays"
        )
    if found["k_max"] is None:
        lines.append(f"  stable at every contact stiffness up to {found['k_max_bound']:g} N/m")
    elif found["k_max"] == 0.0:
        lines.append("  no contact stiffness is stable")
    else:
        lines.append(f"  largest stable contact stiffness: {found['k_max']:.1f} N/m")
    lines += [f"  stable again from {low:.1f} to {high:.1f} N/m" for low, high in found["islands"]]
    lines.append(
        f"  model: {count(found['states'], 'state')}, hyperperiod of "
        f"{count(found['hyperframe_ticks'], 'tick')}, "
        f"{count(found['rigid_body_modes'], 'rigid-body mode')} removed"
    )
    return lines + [f"  note: {note}" for note in found["notes"]]
