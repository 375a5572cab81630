# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a controller renders to the first user of a session.

Stiffness and first resonance of x/f are from the exact model where there is one; else from the
chirp of the session: a series k - m w^2 + c w^4 is fitted to the trusted values of Re(f/x) below
the first peak, each with the weight of its coherence gamma^2/(1 - gamma^2); else from a simulated
press. Two simulated sessions measure every controller the same way, linear or not:

**Free space**: contacts exert no force; a force F cos(w t) moves the device so slowly that the
round trip is a twentieth of a period (2 Hz at most). F/x = -m w^2 + j b w, so

    m = -Re(F/x)/w^2,    b = Im(F/x)/w,

device included. A force held for a tick acts half a tick later than its sample; without accounting
for that a mass would read as a damping of -m w^2 h/2. A motion that differs between both halves of
the fit, or does not follow the force, has no mass and no damping.

**Steady press**: the force goes to F1, to F2 and back to F1, against the opposite users where
there are any, and k = (F2 - F1)/(x2 - x1). A device that still moves in the last second of a hold,
or does not come back, has no stiffness at rest.
"""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.transparency.measured import TRUSTED, measure
from pmwvc_analysis.transparency.pressing import pressing
from pmwvc_analysis.transparency.transparency import ideal_of, transparency, untouched
from pmwvc_core.errors import PmwvcError
from pmwvc_core.network.effects import mean_s
from pmwvc_core.numeric import Array
from pmwvc_core.plant.forces import RecordedForce, recorded_params
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces

FASTEST_HZ, SLOWEST_HZ = 2.0, 0.1  # of the swing
ROUND_TRIPS = 20.0  # in a period of the swing
SPEED_M_S, SWING_N = 0.2, 0.5  # largest, of the bare device
SETTLE_PERIODS, PERIODS = 3, 4  # before and of the fit; an even number
COHERENT, SETTLED = 0.9, 0.05
PRESS_N = (0.5, 1.0)
RISE_S, HOLD_S = 1.0, 4.0
AT_REST, BACK = 0.02, 0.05  # of the step: motion in the last second, distance on return
START_S = 1.0  # until the force of the device is fully there
FAR_M = 10.0  # workspace of the probing sessions: nothing stops the device
LOW = 0.8  # of the peak's frequency: below it the series holds
LEAST = 5  # values to fit a stiffness to
CERTAIN = 1e-4  # what a coherence may lack and still be taken as 1
PROMINENT = 0.2  # of the largest size: what counts as a peak of a measurement
SHOWN_HZ = (0.1, 100.0)


class FreeSpace(NamedTuple):
    """Mass [kg] and damping [N s/m] rendered with nothing touched, device included, at [Hz]."""

    mass_kg: float
    damping_n_s_m: float
    frequency_hz: float


def swing_hz(scenario: Scenario) -> float | None:
    """Return how fast the first user is swung [Hz]; None for round trips of half a second."""
    first = scenario.users[0]
    round_trip_s = mean_s(first.link_up) + mean_s(first.link_down)
    round_trip_s += first.master.frame_s + scenario.server.period_s
    hertz = min(FASTEST_HZ, 1.0 / (ROUND_TRIPS * round_trip_s))
    return hertz if hertz >= SLOWEST_HZ else None


def free_space(scenario: Scenario) -> FreeSpace | None:
    """Return what the first user moves with nothing touched; None where it is unknown."""
    hertz, first = swing_hz(scenario), scenario.users[0]
    if hertz is None or not scenario.environment.known:
        return None
    free = untouched(_roomy(scenario))
    alone = replace(free, users=free.users[:1])
    half = round(PERIODS / 2 / hertz / scenario.tick_s)
    angle = np.pi * PERIODS / half  # per tick: whole periods
    omega = angle / scenario.tick_s
    ticks = 2 * half + round(2.0 * np.pi * SETTLE_PERIODS / angle)
    size = min(SWING_N, SPEED_M_S * omega * float(first.device.mass))
    force = size * np.cos(angle * np.arange(ticks))
    found = _responses(alone, {first.name: force}, ticks * scenario.tick_s + START_S)
    if found is None:
        return None
    applied, moved = (values[-2 * half :] for values in found)
    ratios, held = [], np.exp(-0.5j * angle)
    for rows in (slice(0, half), slice(half, None)):
        push, _ = _sine_of(applied[rows], angle)
        way, coherence = _sine_of(moved[rows], angle)
        if coherence < COHERENT:
            return None
        ratios.append(push * held / way)
    if abs(ratios[1] - ratios[0]) > SETTLED * abs(ratios[1]):
        return None
    return FreeSpace(-ratios[1].real / omega**2, ratios[1].imag / omega, omega / (2.0 * np.pi))


def _sine_of(values: Array, angle: float) -> tuple[complex, float]:
    """Return a sine's complex amplitude and its ratio of the power, without level and drift."""
    turns = angle * np.arange(len(values))
    drift = [np.ones(len(values)), np.linspace(-1.0, 1.0, len(values))]
    basis = np.stack([np.cos(turns), np.sin(turns), *drift], axis=1)
    factors, *_ = np.linalg.lstsq(basis, values)
    left, swing = values - basis @ factors, basis[:, :2] @ factors[:2]
    power = float(np.sum((swing + left) ** 2))
    ratio = 1.0 - float(np.sum(left**2)) / power if power > 0.0 else 0.0
    return complex(factors[0], -factors[1]), ratio


def pressed_stiffness(scenario: Scenario) -> float | None:
    """Return the stiffness of a steady press [N/m]; None where the device never rests in one."""
    forces = pressing(scenario, 0)
    held = not scenario.environment.movable or any(np.any(force) for force in forces[1:])
    if not held:
        return None
    tick_s, first = scenario.tick_s, scenario.users[0]
    settle_s = HOLD_S + 4.0 * (mean_s(first.link_up) + mean_s(first.link_down))
    knots_s = np.cumsum([0.0, *[RISE_S, settle_s] * 3])
    levels = [0.0, *[PRESS_N[0]] * 2, *[PRESS_N[1]] * 2, *[PRESS_N[0]] * 2]
    course = np.interp(np.arange(0.0, knots_s[-1], tick_s), knots_s, levels)
    pushes = {
        user.name: np.multiply.outer(course, -first.side * np.atleast_1d(force))
        for user, force in zip(scenario.users, forces, strict=True)
    }
    found = _responses(_roomy(scenario), pushes, float(knots_s[-1]) + START_S)
    if found is None:
        return None
    x = -first.side * found[1]
    second = round(1.0 / tick_s)
    ends = [round(knot / tick_s) - 1 for knot in knots_s[2::2]]
    one, two, again = (float(x[end]) for end in ends)
    step = two - one
    crept = max(float(np.ptp(x[end - second : end + 1])) for end in ends)
    if step <= 0.0 or crept > AT_REST * step or abs(again - one) > BACK * step:
        return None
    return (PRESS_N[1] - PRESS_N[0]) / step


def _roomy(scenario: Scenario) -> Scenario:
    """Return the scenario with devices that no stop holds; nothing changes or is disturbed."""
    users = (replace(u, device=replace(u.device, workspace_m=FAR_M)) for u in scenario.users)
    task = replace(scenario.task, kind="free")
    return replace(scenario, users=tuple(users), task=task, changes="", disturbances="")


def _responses(
    scenario: Scenario, forces: dict[str, Array], duration_s: float
) -> tuple[Array, Array] | None:
    """Return the first user's force [N] and position [m] while pushed; None where it diverged."""
    forces = {name: force.reshape(len(force), -1) for name, force in forces.items()}
    hands = {
        name: (RecordedForce(0), recorded_params(force, scenario.dof, repeat=False, early=False))
        for name, force in forces.items()
    }
    of = replace(scenario, duration_s=duration_s)
    user = simulate_one(of, Conditions(hands=hands)).users[0]
    applied, x = user.f_h[:, 0], user.x_m[:, 0]
    begun = np.flatnonzero(applied != 0.0)
    if not np.isfinite(x).all() or not len(begun):
        return None
    wanted = forces[scenario.users[0].name][:, 0]
    begin = int(begun[0]) - int(np.flatnonzero(wanted != 0.0)[0])
    rows = slice(begin, begin + len(wanted))
    return (applied[rows], x[rows]) if len(x[rows]) == len(wanted) else None


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
    found = _modelled(scenario, live=live) or measured_rendering(traces, scenario)
    if found is None and (stiffness := pressed_stiffness(scenario)) is not None:
        found = RenderedCurve("press", stiffness)
    return found or NOTHING


def ideal_rendering(scenario: Scenario) -> RenderedCurve:
    """Return the same for direct coupling at every tick without delay."""
    return _modelled(ideal_of(scenario), live=False) or NOTHING


def _modelled(scenario: Scenario, *, live: bool) -> RenderedCurve | None:
    highest = min(SHOWN_HZ[1], 0.25 / scenario.tick_s)
    try:
        found = transparency(scenario, np.geomspace(SHOWN_HZ[0], highest, 300), live=live)
    except (PmwvcError, np.linalg.LinAlgError):  # not linear, not stable, or singular
        return None
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
