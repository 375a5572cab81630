# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. E: waves with filter bank and local model beside plain waves and direct coupling."""

from typing import Any

import numpy as np

from pmwvc_analysis.compare.rendered import NOTHING, measured_rendering
from pmwvc_analysis.models.linearize import build
from pmwvc_analysis.models.stability import k_max
from pmwvc_analysis.transparency.frequency import response
from pmwvc_analysis.transparency.transparency import ideal_of
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.wave.filter_design import design
from reproduction.conditions import bank_gains
from reproduction.figure import Values
from reproduction.scenarios import scenario
from reproduction.single_user import admittances_of, radius_of


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
        rendered = measured_rendering(simulate_one(of), of) or NOTHING
        data[name] = {"hz": rendered.frequency_hz, "size": rendered.admittance}
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
