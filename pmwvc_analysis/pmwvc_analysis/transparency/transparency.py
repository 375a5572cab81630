# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The transmitted admittance of a user's link, beside that of an ideal coupling.

**Transmitted admittance** (App. A Eq. 23): position of the device per force of the hand, x/f
[m/N], from the exact multirate model at the frequency of the force. With a cube the users press
against each other (:mod:`.pressing`). The impedance is f per velocity, 1/(j w x/f) [N s/m]. Where
an impedance matrix couples the axes, the force is along one of them and the others are free: x/f
is the entry of the admittance matrix on its diagonal.

**Ideal**: the same device, contact and object with direct coupling at every tick and no delay.

**Rendered**, as limits at rest: stiffness f/x [N/m], with waves 1/k = 1/K_contact + tau/(2b), tau
the lag once around; damping, the slope of Im(f/x) over w, pressing [N s/m]; with nothing touched
mass, -Re(f/x)/w^2 [kg], and damping, Im(f/x)/w [N s/m], the force acting half a tick after its
sample; less the device's own they are the link's (with waves b tau/2 and none).
"""

import dataclasses
import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from pmwvc_analysis.models import stability
from pmwvc_analysis.models.linear import axes_of, notes_of
from pmwvc_analysis.models.linearize import build, spectral_radius, stable
from pmwvc_analysis.models.loop import LinearLoop
from pmwvc_analysis.transparency.frequency import first_peak_hz, limit_at_rest, low_hz, response
from pmwvc_analysis.transparency.pressing import pressing
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Complex
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.names import varied
from pmwvc_core.scenario.scenario import Scenario

HIGHEST = 0.25  # of the tick rate; x/f falls to nothing at half of it
LEAST_PERIOD_S = 1e-3  # of a server; with a shorter tick the ideal steps at its next multiple
STEADY = 0.05  # relative change per octave above which there is no limit but free motion


@dataclass(frozen=True)
class Rendering:
    """Rendered quantities of one coupling; None where there is no such limit."""

    admittance_dc: float | None = None  # [m/N]
    k_felt: float | None = None  # [N/m]
    b_felt: float | None = None  # pressing [N s/m]
    mass_felt: float | None = None  # with nothing touched [kg], and likewise
    b_free: float | None = None  # [N s/m]
    first_peak_hz: float | None = None


@dataclass(frozen=True)
class Transparency:
    """Transmitted admittance of one user along one axis, of the link and of the ideal coupling."""

    user: str
    axis: int
    frequency_hz: Array  # (points,)
    admittance: Complex  # (points,) [m/N]
    ideal_admittance: Complex  # NaN where the ideal coupling is not stable
    rendered: Rendering
    ideal: Rendering
    notes: list[str]
    source: str = "model"  # or "measured", by simulated sessions: without curves


def transparency(
    scenario: Scenario,
    frequency_hz: Array | None = None,
    *,
    user: int = 0,
    axis: int = 0,
    live: bool = False,
) -> Transparency:
    """Return the admittance transmitted to one user along an axis, at frequencies that are by
    default 0.1 Hz to a quarter of the tick rate. Grip contacts are taken as touching. PmwvcError
    if the session is not stable, or something in it is not linear.
    """
    if frequency_hz is None:
        frequency_hz = np.geomspace(0.1, HIGHEST / scenario.tick_s, 300)
    radius = float(stability.radii(scenario, live=live)[0])
    if not stable(radius):
        raise PmwvcError(
            f"{scenario.name} is not stable (spectral radius {radius:.5g}): it has no frequency "
            "response; 'pmwvc stability' gives the largest stiffness"
        )
    of: dict[str, Any] = {"user": user, "axis": axis}
    link, admittance = _side(build(scenario, live=live), frequency_hz, **of)
    axes, notes = axes_of(scenario), notes_of(scenario)
    if axes > 1:
        notes.append(f"Along axis {axis + 1} of {axes}, the other axes free.")
    if link.admittance_dc is None:
        notes.append("Under a steady force the device keeps moving: there is no static stiffness.")
    direct, ideal, perfect = (
        ideal_of(scenario),
        Rendering(),
        np.full(len(frequency_hz), np.nan + 0j),
    )
    if stable(float(stability.radii(direct)[0])):
        ideal, perfect = _side(build(direct), frequency_hz, **of)
    else:
        notes.append(
            "The ideal coupling is not stable at this tick: it has no frequency response."
        )
    name = scenario.users[user].name
    return Transparency(name, axis, frequency_hz, admittance, perfect, link, ideal, notes)


def _side(
    model: LinearLoop, frequency_hz: Array, *, user: int, axis: int
) -> tuple[Rendering, Complex]:
    """Return what one coupling renders in a steady press, and its admittance."""
    forces = pressing(model.scenario, user, axis)
    admittance = response(model, frequency_hz, user=user, forces=forces, axis=axis)
    return _rendered(model, user, axis, forces), admittance


def ideal_of(scenario: Scenario) -> Scenario:
    """Return the scenario with direct coupling at every tick, without delay."""
    at_once: dict[str, Any] = {"link_up": LinkParams(), "link_down": LinkParams()}
    users = tuple(
        dataclasses.replace(user, master=dataclasses.replace(user.master, rate_drop=1), **at_once)
        for user in (user.in_contact for user in scenario.users)
    )
    ticks = math.ceil(LEAST_PERIOD_S / scenario.tick_s - 1e-9)
    server = dataclasses.replace(scenario.server, period_s=ticks * scenario.tick_s)
    return dataclasses.replace(scenario, controller="direct", users=users, server=server)


def untouched(scenario: Scenario) -> Scenario:
    """Return the scenario with contacts that exert no force, and the impedance of free motion."""
    scenario = varied(scenario, "master.contact_impedance", None)
    for name in ("contact_stiffness", "contact_damping"):
        scenario = varied(scenario, f"server.{name}", 0.0)
    return scenario


def _rendered(model: LinearLoop, user: int, axis: int, forces: Array) -> Rendering:
    of: dict[str, Any] = {"user": user, "axis": axis}
    peak = first_peak_hz(partial(response, model, forces=forces, **of), model.tick_s)
    frequency = low_hz(peak)
    omega = 2.0 * np.pi * frequency
    pressed = response(model, frequency, forces=forces, **of)
    dc = damping = mass = b_free = None
    if abs(pressed[1] - pressed[0]) <= STEADY * abs(pressed[0]):
        dc = limit_at_rest(pressed.real)
        damping = limit_at_rest((1.0 / pressed).imag / omega)
    free = build(untouched(model.scenario), live=model.live)
    if stable(spectral_radius(free)):
        moved = np.exp(-0.5j * omega * model.tick_s) / response(free, frequency, **of)
        mass, b_free = limit_at_rest(-moved.real / omega**2), limit_at_rest(moved.imag / omega)
    k_felt = None if dc is None or dc <= 0.0 else 1.0 / dc
    return Rendering(dc, k_felt, damping, mass, b_free, peak)
