# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Simulated sessions that measure what any controller renders to a user, linear or not.

**Free space**: contacts exert no force; a force F cos(w t) moves the device so slowly that the
round trip is a twentieth of a period (2 Hz at most). F/x = -m w^2 + j b w, so

    m = -Re(F/x)/w^2,    b = Im(F/x)/w,

device included; less the device's own they are the link's. A force held for a tick acts half a
tick later than its sample; without accounting for that a mass would read as a damping of
-m w^2 h/2. A motion that differs between both halves of
the fit, or does not follow the force, has no mass and no damping.

**Steady press**: the force goes to F1, to F2 and back to F1, against the opposite users where
there are any and an object so heavy that it stays; k = (F2 - F1)/(x2 - x1) of the means over the
last second of each hold. A device whose mean still moves within it, or that does not come back,
has no stiffness at rest, nor has a user who is alone with an object.
"""

from dataclasses import asdict, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.models.linear import nonlinear
from pmwvc_analysis.transparency.answer import rendered_words
from pmwvc_analysis.transparency.pressing import pressing
from pmwvc_analysis.transparency.transparency import (
    Rendering,
    Transparency,
    ideal_of,
    untouched,
)
from pmwvc_core.errors import PmwvcError
from pmwvc_core.network.effects import mean_s
from pmwvc_core.numeric import Array
from pmwvc_core.plant.forces import RecordedForce, recorded_params
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.session import simulate_one

FASTEST_HZ, SLOWEST_HZ = 2.0, 0.1  # of the swing
ROUND_TRIPS = 20.0  # in a period of the swing
SPEED_M_S, SWING_N = 0.2, 0.5  # largest, of the bare device
SETTLE_PERIODS, PERIODS = 3, 4  # before and of the fit; an even number
COHERENT, SETTLED = 0.9, 0.05
PRESS_N = (0.5, 1.0)
RISE_S, HOLD_S = 1.0, 4.0
AT_REST, BACK = 0.02, 0.05  # of the step: motion in the last second, distance on return
HELD_KG, HELD_N_S_M = 1e3, 1e3  # of an object that stays where forces balance
START_S = 1.0  # until the force of the device is fully there
FAR: Any = {"workspace_m": 10.0}  # of the probing sessions: nothing stops the device
UNKNOWN = "nothing is known"
RESTLESS = "stiffness unknown (the device settles in no press, or not at the same place)"
INCOHERENT = "mass and damping unknown (motion does not cohere, or half a second late)"


class FreeSpace(NamedTuple):
    """Mass [kg] and damping [N s/m] with nothing touched, at a frequency [Hz]."""

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
    found = _responses(alone, {first.name: force})
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
    felt = float(-ratios[1].real / omega**2), float(ratios[1].imag / omega)
    return FreeSpace(*felt, omega / (2.0 * np.pi))


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
    tick_s, first, forces = scenario.tick_s, scenario.users[0], pressing(scenario, 0)
    alone = scenario.environment.movable and not np.any(forces[1:])
    if alone or scenario.environment.linear is None:  # a scene, of which nothing holds the bodies
        return None
    held = replace(scenario.server, object_mass=HELD_KG, object_damping=HELD_N_S_M)
    settle_s = HOLD_S + 4.0 * (mean_s(first.link_up) + mean_s(first.link_down))
    knots_s = np.cumsum([0.0, *[RISE_S, settle_s] * 3])
    levels = [0.0, *[PRESS_N[0]] * 2, *[PRESS_N[1]] * 2, *[PRESS_N[0]] * 2]
    course = -first.side * np.interp(np.arange(0.0, knots_s[-1], tick_s), knots_s, levels)
    pushes = (np.multiply.outer(course, force) for force in forces)
    each_n = {user.name: push for user, push in zip(scenario.users, pushes, strict=True)}
    found = _responses(_roomy(replace(scenario, server=held)), each_n)
    if found is None:
        return None
    x, half = -first.side * found[1], round(0.5 / tick_s)
    ends = [round(knot / tick_s) for knot in knots_s[2::2]]
    one, two, again = (x[end - 2 * half : end].reshape(2, half).mean(axis=1) for end in ends)
    step = float(two.mean() - 0.5 * (one.mean() + again.mean()))
    crept = max(float(np.ptp(each)) for each in (one, two, again))
    if step <= 0.0 or crept > AT_REST * step or abs(again.mean() - one.mean()) > BACK * step:
        return None
    return (PRESS_N[1] - PRESS_N[0]) / step


def probed(scenario: Scenario, user: int = 0) -> tuple[Rendering, str]:
    """Return what the simulated sessions show of a link, and how each was measured, in words."""
    own, *others = sorted(scenario.users, key=lambda each: each is not scenario.users[user])
    first = replace(scenario, users=(own, *others))
    k, free = pressed_stiffness(first), free_space(first)
    press = f"stiffness by a press of {PRESS_N[0]:g} to {PRESS_N[1]:g} N" if k else RESTLESS
    if free is None:
        return Rendering(k and 1.0 / k, k), f"{press}, {INCOHERENT}"
    swing = f"mass and damping by a swing of at most {SWING_N:g} N at {free.frequency_hz:.3g} Hz"
    return Rendering(k and 1.0 / k, k, None, *free[:2]), f"{press}, {swing}"


def measured_words(scenario: Scenario, user: int = 0) -> str:
    """Return the same in a sentence."""
    found, how = probed(scenario, user)
    return f"Measured in simulated sessions: {how}: {rendered_words(asdict(found)) or UNKNOWN}."


def measured_transparency(scenario: Scenario, user: int, error: PmwvcError) -> Transparency:
    """Return what is rendered where no linear model holds, without curves."""
    (found, how), (ideal, _) = probed(scenario, user), probed(ideal_of(scenario), user)
    why = ", ".join(dict.fromkeys(each.text for each in nonlinear(scenario))) or str(error)
    notes = [f"No linear model holds ({why}). Measured in simulated sessions: {how}."]
    name, none, curve = scenario.users[user].name, np.zeros(0), np.zeros(0, dtype=np.complex128)
    return Transparency(name, 0, none, curve, curve, found, ideal, notes, "measured")


def _roomy(scenario: Scenario) -> Scenario:
    """Return the scenario with devices that no stop holds; nothing changes or is disturbed."""
    users = tuple(replace(u, given_device=replace(u.given_device, **FAR)) for u in scenario.users)
    of = replace(scenario, users=users, changes="", disturbances="")
    return replace(of, task=replace(of.task, kind="free"))


def _responses(scenario: Scenario, forces: dict[str, Array]) -> tuple[Array, Array] | None:
    """Return the first user's force [N] and position [m] while pushed; None where it diverged."""
    forces = {name: force.reshape(len(force), -1) for name, force in forces.items()}
    once = partial(recorded_params, axes=scenario.dof, repeat=False, early=False)
    hands = {name: (RecordedForce(0), once(force)) for name, force in forces.items()}
    wanted = forces[scenario.users[0].name][:, 0]
    of = replace(scenario, duration_s=len(wanted) * scenario.tick_s + START_S)
    user = simulate_one(of, Conditions(hands=hands)).users[0]
    applied, x = user.f_h[:, 0], user.x_m[:, 0]
    begun = np.flatnonzero(applied != 0.0)
    if not np.isfinite(x).all() or not len(begun):
        return None
    begin = int(begun[0]) - int(np.flatnonzero(wanted != 0.0)[0])
    rows = slice(begin, begin + len(wanted))
    return (applied[rows], x[rows]) if len(x[rows]) == len(wanted) else None
