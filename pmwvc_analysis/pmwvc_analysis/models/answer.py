# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The stability of one scenario as plain data and in sentences."""

import math
from typing import Any

import numpy as np

from pmwvc_analysis.models import stability
from pmwvc_analysis.models.linear import notes_of
from pmwvc_analysis.models.linearize import stable
from pmwvc_analysis.models.loop import LinearLoop, loop_of
from pmwvc_analysis.models.response import OUTPUTS
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.words import count


def answer(scenario: Scenario, *, live: bool = False) -> dict[str, Any]:
    """Return the answer of the exact model for a scenario: ``spectral_radius`` per hyperperiod of
    ``hyperframe_ticks``, ``stable``, ``k_max`` [N/m] (None: nothing up to ``k_max_bound`` is
    unstable, unless ``k_max_unknown`` says why) and stable ``islands`` above, ``states`` with the
    ``rigid_body_modes`` taken out, ``slowest`` (``frequency_hz``, None where it is not clear, and
    growth ``per_second`` of the largest eigenvalue), ``notes``.
    """
    limit = stability.k_max(scenario, live=live)
    model = stability.model_of(scenario, live=live)
    largest = model.largest()
    radius = abs(largest)
    hertz = _frequency_hz(loop_of(scenario, live=live, outputs=True), largest)
    return {
        "scenario": scenario.name,
        "live": live,
        "spectral_radius": radius,
        "stable": stable(radius),
        "k_max": limit.first,
        "k_max_bound": limit.bound,
        "k_max_unknown": limit.unknown,
        "islands": [list(island) for island in limit.islands],
        "rigid_body_modes": model.motions,
        "states": model.count,
        "hyperframe_ticks": model.ticks,
        "slowest": {
            "frequency_hz": hertz,
            "per_second": math.log(radius) / (model.ticks * scenario.tick_s) if radius else None,
        },
        "notes": notes_of(scenario),
    }


CLEAR = 0.5  # of the strongest harmonic's power: what another may have at most


def _frequency_hz(loop: LinearLoop, value: complex) -> float | None:
    """Return the frequency of an eigenvalue's motion; None where none is seen or two are as
    strong.

    Over a hyperperiod of N ticks it is known up to multiples of 1/(N T_c). Within, y(k)
    lambda^(-k/N) has period N, and its largest harmonic j gives (arg lambda + 2 pi j)/(2 pi N
    T_c).
    """
    if value == 0.0:
        return None
    ticks, angle = loop.ticks, float(np.angle(value))
    equations, (_, read) = loop.equations(np.array([value]))[0], loop.system
    vector = np.linalg.svd(equations)[2][-1].conj()
    by_output = (read[:, : len(vector)] @ vector).reshape(
        len(loop.scenario.users), len(OUTPUTS), ticks, -1
    )
    fade = np.exp(-(np.log(np.abs(value)) + 1j * angle) * np.arange(ticks) / ticks)
    for name in ("xd", "f"):  # of a motion that no device takes part in, its force
        seen = by_output[:, OUTPUTS.index(name)].swapaxes(1, 2).reshape(-1, ticks)
        if not seen.any():
            continue
        power = np.sum(np.abs(np.fft.fft(seen * fade, axis=1)) ** 2, axis=0)
        harmonics = np.fft.fftfreq(ticks, 1.0 / ticks)
        hertz = np.abs(angle + 2.0 * np.pi * harmonics) / (2.0 * np.pi * ticks * loop.tick_s)
        best = int(np.argmax(power))
        others = np.abs(hertz - hertz[best]) > 1e-9 * (1.0 / loop.tick_s)
        if not np.any(power[others] > CLEAR * power[best]):
            return float(hertz[best])
    return None


def sentences(found: dict[str, Any]) -> list[str]:
    """Return an answer in words."""
    word = "stable" if found["stable"] else "NOT stable"
    slowest = found["slowest"]
    rate = slowest["per_second"]
    lines = [f"{found['scenario']}: {word}, spectral radius {found['spectral_radius']:.7g}"]
    if rate is not None:
        course = "growing" if rate > 0.0 else "decaying"
        hertz = slowest["frequency_hz"]
        mode = "frequency not clear" if hertz is None else f"{hertz:.2f} Hz"
        lines.append(
            f"  dominant mode: {mode}, {course}, time constant {1.0 / abs(rate):.3g} s"
            if rate and not (rate > 0.0 and found["stable"])  # slower than what counts as growth
            else f"  dominant mode: {mode}, neither grows nor decays"
        )
    limit = (found[name] for name in ("k_max", "k_max_bound", "islands", "k_max_unknown"))
    lines.append(f"  {stability.StabilityLimit(*limit).text}")
    lines += [f"  stable again from {low:.1f} to {high:.1f} N/m" for low, high in found["islands"]]
    lines.append(
        f"  model: {count(found['states'], 'state')}, hyperperiod of "
        f"{count(found['hyperframe_ticks'], 'tick')}, "
        f"{count(found['rigid_body_modes'], 'rigid-body mode')} removed"
    )
    return lines + [f"  note: {note}" for note in found["notes"]]
