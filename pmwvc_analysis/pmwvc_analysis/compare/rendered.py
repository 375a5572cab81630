# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a controller renders to the first user of a session, as a curve over frequency.

Stiffness and first resonance of x/f are from the exact model where one holds and leaves no effect
of the links out; else from the chirp of the session: a series k - m w^2 + c w^4 is fitted to the
trusted values of Re(f/x) below the first peak, each with the weight of its coherence
gamma^2/(1 - gamma^2); else from a simulated press (:mod:`.probes`), with the model's curve.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from pmwvc_analysis.compare.probes import pressed_stiffness
from pmwvc_analysis.models.linear import left_out
from pmwvc_analysis.transparency.measured import TRUSTED, measure
from pmwvc_analysis.transparency.transparency import transparency
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

LOW = 0.8  # of the peak's frequency: below it the series holds
LEAST = 5  # values to fit a stiffness to
CERTAIN = 1e-4  # what a coherence may lack and still be taken as 1
PROMINENT = 0.2  # of the largest size: what counts as a peak of a measurement
SHOWN_HZ = (0.1, 100.0)


@dataclass(frozen=True)
class RenderedCurve:
    """Rendered stiffness [N/m], first peak [Hz] and the curve |x/f| [m/N] they come from."""

    source: str = ""  # "model", "measured", "press"; empty where nothing is known
    k_felt: float | None = None
    first_peak_hz: float | None = None
    frequency_hz: Array = field(default_factory=lambda: np.zeros(0))  # (points,)
    admittance: Array = field(default_factory=lambda: np.zeros(0))  # (points,)


NOTHING = RenderedCurve()


def rendering(traces: SessionTraces, scenario: Scenario, *, live: bool) -> RenderedCurve:
    """Return stiffness and resonance rendered to the first user in a session."""
    model = _modelled(scenario, live=live)
    if model.source and not left_out(scenario):
        return model
    if (found := measured_rendering(traces, scenario)) is not None:
        return found
    k = pressed_stiffness(scenario)
    return replace(model, source="press" if k else "", k_felt=k, first_peak_hz=None)


def _modelled(scenario: Scenario, *, live: bool) -> RenderedCurve:
    highest = min(SHOWN_HZ[1], 0.25 / scenario.tick_s)
    try:
        found = transparency(scenario, np.geomspace(SHOWN_HZ[0], highest, 300), live=live)
    except (PmwvcError, np.linalg.LinAlgError):  # not linear, not stable, or singular
        return NOTHING
    own, size = found.rendered, np.abs(found.admittance)
    return RenderedCurve("model", own.k_felt, own.first_peak_hz, found.frequency_hz, size)


def measured_rendering(traces: SessionTraces, scenario: Scenario) -> RenderedCurve | None:
    """Return the same from the chirp of a session; None without one."""
    if not scenario.users[0].operator.is_chirp or not traces.users:
        return None
    try:
        found = measure(traces.users[0], scenario.users[0])
    except PmwvcError:  # the hand's force is unknown, or there is too little of it
        return None
    from scipy.signal import find_peaks

    stiffness, peak_hz = None, None
    trusted = found.coherence >= TRUSTED
    hertz, admittance = found.frequency_hz[trusted], found.admittance[trusted]
    if len(hertz) >= LEAST:
        edges = np.pad(np.abs(admittance), 1, mode="edge")
        smooth = np.convolve(edges, np.ones(3) / 3.0, mode="valid")
        peaks, _ = find_peaks(smooth, prominence=PROMINENT * float(smooth.max()))
        peak_hz = float(hertz[peaks[0]]) if len(peaks) else None
    below = hertz <= LOW * (peak_hz or math.inf)
    if below.sum() >= LEAST:
        square = (2.0 * np.pi * hertz[below]) ** 2
        powers = np.stack([square**0, square, square**2], axis=1) / square.max() ** np.arange(3)
        coherence = found.coherence[trusted][below]
        weight = np.sqrt(coherence / (1.0 - coherence + CERTAIN))
        values = weight * (1.0 / admittance[below]).real
        (k, _, _), *_ = np.linalg.lstsq(weight[:, np.newaxis] * powers, values)
        stiffness = float(k)
    size = np.abs(found.admittance)
    return RenderedCurve("measured", stiffness, peak_hz, found.frequency_hz, size)
