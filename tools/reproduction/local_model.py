# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. E: waves with filter bank and local model beside plain waves and direct coupling.

Of a sweep, the rendered stiffness is that of a series k - m w^2 + c w^4, fitted to the trusted
values of Re(f/x) below the first peak, each with the weight of its coherence
gamma^2/(1 - gamma^2).
"""

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.signal import find_peaks

from pmwvc_analysis.models.linearize import build
from pmwvc_analysis.models.stability import k_max
from pmwvc_analysis.transparency.frequency import response
from pmwvc_analysis.transparency.transparency import ideal_of
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces
from pmwvc_core.wave.filter_design import design
from reproduction.conditions import bank_gains
from reproduction.figure import Values
from reproduction.scenarios import scenario
from reproduction.single_user import admittances_of, radius_of
from reproduction.sweep import TRUSTED, measure

LOW = 0.8  # of the peak's frequency: below it the series holds
LEAST = 5  # values to fit a stiffness to
CERTAIN = 1e-4  # what a coherence may lack and still be taken as 1
PROMINENT = 0.2  # of the largest size: what counts as a peak of a measurement


class Swept(NamedTuple):
    """Rendered stiffness [N/m], first peak [Hz] and the curve |x/f| [m/N] they come from."""

    k_felt: float | None
    first_peak_hz: float | None
    hertz: Array  # (points,)
    size: Array  # (points,)


def swept(traces: SessionTraces, of: Scenario) -> Swept:
    """Return what the chirp of a session shows."""
    found = measure(traces.users[0], of.users[0])
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
    return Swept(stiffness, peak_hz, found.frequency_hz, np.abs(found.admittance))


def limits(parameters: Values) -> Values:
    """Return the largest stiffness of the environment over that of the local model, by gain."""
    local = np.linspace(*parameters["local_stiffness"])
    data: Values = {"local_stiffness": local}
    numbers: Values = {"plain": k_max(scenario(parameters["plain"], users=1)).first}
    for gain in parameters["gains"]:
        of = varied(scenario(parameters["model"], users=1), "master.position.gain", gain)
        found = [k_max(varied(of, "master.local_model.stiffness", k)).first for k in local]
        data[f"gain_{gain:g}"] = found
        known = [value for value in found if value is not None]
        numbers[f"least_gain_{gain:g}"] = min(known) if known else None
    for name, changed in parameters["banks"].items():
        master = scenario({**parameters["model"], **changed}, users=1).users[0].master
        numbers |= bank_gains(name, design(master.filter, tick_s=master.tick_s), master.bank)
    numbers["spectral_radius_damping_1"] = _radius(parameters["model"], damping=1.0)
    numbers["spectral_radius_damping_3"] = _radius(parameters["model"], damping=3.0)
    return {"data": data, "numbers": numbers}


def _radius(model: Values, *, damping: float) -> float:
    values = {**model, "master.local_model.damping": damping, "server.contact_stiffness": 500.0}
    return radius_of(values)


def admittances(parameters: Values) -> Values:
    """Return |x/f| over frequency for every connection, from the model."""
    low, high = np.linspace(*parameters["low_hz"]), np.linspace(*parameters["high_hz"])
    return admittances_of(_scenarios(parameters), low, high)


def measured(parameters: Values) -> Values:
    """Return |x/f| as sweeps show it."""
    data: Values = {}
    numbers: Values = {}
    for name, of in {**_scenarios(parameters), "ideal": _ideal(parameters)}.items():
        rendered = swept(simulate_one(of), of)
        data[name] = {"hz": rendered.hertz, "size": rendered.size}
        numbers[f"k_felt_{name}"] = rendered.k_felt
        numbers[f"first_peak_hz_{name}"] = rendered.first_peak_hz
    return {"data": data, "numbers": numbers}


def impedances(parameters: Values) -> Values:
    """Return |F_m/X_m|, force of the controller over position of the device."""
    hertz = np.linspace(*parameters["hz"])
    data: Values = {"hz": hertz}
    numbers: Values = {}
    for name, of in {**_scenarios(parameters), "ideal": _ideal(parameters)}.items():
        model = build(of)
        size = np.abs(response(model, hertz, output="f") / response(model, hertz, output="x"))
        data[name] = size
        numbers[f"lowest_{name}"] = float(size[0])
        numbers[f"mean_to_10_hz_{name}"] = float(np.mean(size[hertz <= 10.0]))
    return {"data": data, "numbers": numbers}


def _scenarios(parameters: Values) -> dict[str, Scenario]:
    """Return the connections by name."""
    session: dict[str, Any] = parameters.get("session", {})
    return {
        name: scenario({**parameters["model"], **curve["values"]}, users=1, **session)
        for name, curve in parameters["curves"].items()
    }


def _ideal(parameters: Values) -> Scenario:
    return ideal_of(scenario(parameters["model"], users=1, **parameters.get("session", {})))
