# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The criteria by which impedance, filter and hold are chosen: margin, feel, noise.

**Margin**: spectral radius of the exact model, in touch and with nothing touched (then every wave
comes back, and a device without damping is damped by filter and hold alone), largest
contact stiffness, largest ratio of packet energy to wave energy (aliasing), and whether every part
is passive by itself.

**Feel**: stiffness of a steady press and mass in free motion, from the exact model, beside those
of the ideal coupling. A change of stiffness or of weight of about 23 % is what people just notice;
in that unit the cost of a choice is

    cost^2 = [ln(k_felt/k_ideal)/ln 1.23]^2 + [ln((m_felt + m_arm)/(m_ideal + m_arm))/ln 1.23]^2,

the mass together with that of the arm, which moves along. A larger impedance b stiffens the link,
2b/tau, and makes it heavier, b tau/2, so there is a best one.

**Noise**: what the steps of an encoder make of the force. A position rounded to steps d has the
variance d^2/12; its differences over a tick T_c make a force of b d/(sqrt(6) T_c), root mean
square. Where the scenario's device has such an encoder the noise counts in the cost, 0.1 N (a
tenth of a press of 1 N) for one just noticeable step:

    cost^2 = ... + (noise/0.1 N)^2.

For an exact device the noise of a 10 um encoder is shown and does not count.

Where a scenario is not linear, radii, stiffnesses and masses are those of its nearest linear one
(:mod:`pmwvc_analysis.models.linear`); passivity, aliasing and noise are those of the scenario.
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import SupportsFloat

import numpy as np

from pmwvc_analysis.models import stability
from pmwvc_analysis.models.linear import outside, relative
from pmwvc_analysis.prediction import lag, prediction
from pmwvc_analysis.transparency.transparency import transparency, untouched
from pmwvc_core.params import FilterParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.wave.impedance import MatrixImpedance

NOTICED_N = 0.1  # [N] force noise, root mean square, that counts as one step
NOTICED = math.log(1.23)  # just noticeable ratio of stiffnesses and of weights
ENCODER_STEP_M = 1e-5  # taken where the scenario's device is exact


@dataclass(frozen=True)
class Choice:
    """One impedance [N s/m], filter and hold, for every user; on the strict channel the scenario's
    filter and hold stay as they are.
    """

    impedance: float
    filter: FilterParams
    hold: str

    def settings(self, scenario: Scenario) -> dict[str, float | str]:
        """Return what gives a scenario this choice, as parameters by name."""
        found: dict[str, float | str] = {"master.impedance": round(self.impedance, 2)}
        if not scenario.strict:
            found["master.hold"] = self.hold
        if any(user.master.impedance_matrix for user in scenario.users):
            found["master.impedance_matrix"] = ""
        if any(user.contact.impedance_matrix for user in scenario.users):
            found["server.impedance_matrix"] = ""
        if any(user.contact.impedance is not None for user in scenario.users):
            found["server.impedance"] = "null"
        if scenario.strict:
            return found
        default = FilterParams()
        for field in dataclasses.fields(FilterParams):
            value = getattr(self.filter, field.name)
            before = {getattr(user.master.filter, field.name) for user in scenario.users}
            if field.name == "kind" or {value, getattr(default, field.name)} | before != {value}:
                found[f"master.filter.{field.name}"] = "null" if value is None else value
        return found

    def applied(self, scenario: Scenario) -> Scenario:
        """Return the scenario with this choice for every user, the same at both ends."""
        users = tuple(
            dataclasses.replace(
                user,
                master=dataclasses.replace(
                    user.master,
                    impedance=self.impedance,
                    impedance_matrix="",
                    filter=self.filter,
                    hold=self.hold,
                ),
                contact=dataclasses.replace(user.contact, impedance=None, impedance_matrix=""),
            )
            for user in scenario.users
        )
        return dataclasses.replace(scenario, users=users)


@dataclass(frozen=True)
class AsGiven(Choice):
    """The impedance, filter and hold that a scenario has; ``impedance`` is that of the first
    user's master, of a ``matrix`` what a force along the first axis meets.
    """

    matrix: MatrixImpedance | None = None

    def settings(self, scenario: Scenario) -> dict[str, float | str]:
        """Return the choice as parameters by name; without an impedance that no number gives."""
        found = super().settings(scenario)
        b = {user.impedance for user in scenario.users}
        b |= {user.server_impedance for user in scenario.users}
        if len(b) > 1 or any(isinstance(each, MatrixImpedance) for each in b):
            found = {name: value for name, value in found.items() if "impedance" not in name}
        return found

    def applied(self, scenario: Scenario) -> Scenario:
        """Return the scenario."""
        return scenario


@dataclass(frozen=True)
class Rating:
    """Rating of a choice for the first user; feel is None where the loop is not stable."""

    choice: Choice
    stable: bool  # in touch and free
    spectral_radius: float  # in touch
    free_radius: float  # with nothing touched
    k_max: float | None  # [N/m] None: no limit found
    k_max_unknown: str  # why it is not known; empty where it is
    passive: bool
    aliasing_gain: float | None  # None: nothing is sampled (the strict channel)
    lag_s: float | None  # None: not known of code from another package
    k_felt: float | None  # [N/m]
    k_ideal: float | None
    mass_felt: float | None  # [kg]
    mass_ideal: float | None
    noise_n: float  # [N] root mean square
    cost: float | None
    simulated: str | None = None  # stable, or how it was not; None: not simulated
    simulated_passivity: str | None = None  # the verdict where a port was not passive


def rated(scenario: Scenario, choice: Choice, *, live: bool) -> Rating:
    """Return what a choice does for a scenario, along the first axis; PmwvcError where the periods
    of the scenario hardly ever meet.
    """
    chosen = choice.applied(scenario)
    linear = _linear(chosen)
    user = chosen.users[0]
    touching, free = _radii(linear, live=live)
    stable = _stable((touching, free))
    limit = stability.k_max(linear, live=live)
    found = transparency(linear, np.ones(1), live=live) if stable else None  # at rest is all
    own = found.rendered if found else None
    rating = Rating(
        choice=choice,
        stable=stable,
        spectral_radius=touching,
        free_radius=free,
        k_max=limit.first,
        k_max_unknown=limit.unknown,
        passive=prediction.passive(chosen),
        aliasing_gain=None if chosen.strict else prediction.aliasing_gain(user),
        lag_s=None if outside(chosen) else lag.lag_s(user, chosen, live=live),
        k_felt=own.k_felt if own else None,
        k_ideal=_ideal(found.ideal.k_felt, user.contact.contact_stiffness) if found else None,
        mass_felt=own.mass_felt if own else None,
        mass_ideal=_ideal(found.ideal.mass_felt, user.device.mass) if found else None,
        noise_n=noise_n(scenario, choice.impedance),
        cost=None,
    )
    counts = 0.0 if velocity_step(scenario) is None else rating.noise_n
    return dataclasses.replace(rating, cost=_cost(rating, float(user.operator.mass), counts))


def is_stable(scenario: Scenario, choice: Choice, *, live: bool) -> bool:
    """Tell whether the loop with a choice is stable, in touch and with nothing touched."""
    linear = _linear(choice.applied(scenario))
    return _stable(_radii(linear, live=live))


def _linear(scenario: Scenario) -> Scenario:
    near = relative(scenario)
    return near.scenario if near else scenario


def _radii(linear: Scenario, *, live: bool) -> tuple[float, float]:
    """Return the spectral radii in touch and with nothing touched."""
    touching, free = (
        float(stability.radii(each, live=live)[0]) for each in (linear, untouched(linear))
    )
    return touching, free


def _stable(radii: tuple[float, float]) -> bool:
    """Tell whether both are those of a stable loop."""
    return all(map(stability.stable, radii))


def velocity_step(scenario: Scenario) -> float | None:
    """Return the largest velocity that one step of an encoder makes [m/s]; None where velocities
    are exact.
    """
    steps = [
        float(user.device.encoder_step_m) / float(user.master.tick_s)
        for user in scenario.users
        if user.device.differences or not user.device.is_simulated
    ]
    return max(steps, default=0.0) or None


def noise_n(scenario: Scenario, impedance: float) -> float:
    """Return the force noise of the encoder's steps [N], root mean square."""
    steps = [float(user.device.encoder_step_m) for user in scenario.users]
    step = max(steps) or ENCODER_STEP_M
    return impedance * step / (math.sqrt(6.0) * scenario.tick_s)


def cost_of(k_ratio: float, m_ratio: float, noise_n: float = 0.0) -> float:
    """Return the distance from the ideal in just noticeable steps."""
    ratios = math.hypot(math.log(k_ratio), math.log(m_ratio)) / NOTICED
    return math.hypot(ratios, noise_n / NOTICED_N)


def _ideal(coupled: float | None, own: SupportsFloat) -> float | None:
    """Return what the ideal coupling gives, and where that is not stable itself (a wall without
    damping, sampled) what the contact or the device is by itself.
    """
    return coupled if coupled is not None else (float(own) or None)


def _cost(rating: Rating, arm_kg: float, noise_n: float) -> float | None:
    """Return the cost of what is known; None where nothing is, or what an ideal coupling renders
    is not.
    """
    if (rating.k_ideal and not rating.k_felt) or (rating.mass_ideal and not rating.mass_felt):
        return None
    k_ratio = m_ratio = 1.0
    if rating.k_felt and rating.k_ideal:
        k_ratio = rating.k_felt / rating.k_ideal
    if rating.mass_felt and rating.mass_ideal:
        m_ratio = (rating.mass_felt + arm_kg) / (rating.mass_ideal + arm_kg)
    if not rating.stable or (rating.k_felt is None and rating.mass_felt is None):
        return None
    return cost_of(max(k_ratio, 1e-9), max(m_ratio, 1e-9), noise_n)
