# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The criteria by which impedance, filter and hold are chosen: margin, feel, noise.

**Margin**: spectral radius of the exact model, in touch and with nothing touched (then every wave
comes back, and a device without damping is damped by filter and hold alone), aliasing, and whether
every part is passive by itself.

**Feel**: stiffness of a steady press and mass in free motion, from the exact model, beside those
of the ideal coupling, in changes that people just notice (some 23 %); the mass with that of the
arm. **Noise**: an encoder's steps d have the variance d^2/12; their differences over a tick T_c
make a force of b d/(sqrt(6) T_c), root mean square. Where the scenario's device has such an
encoder 0.1 N count as much as one difference; else that of a 10 um encoder is only shown::

    cost^2 = [ln(k_felt/k_ideal)/ln 1.23]^2 + [ln((m_felt + m_arm)/(m_ideal + m_arm))/ln 1.23]^2
             + (noise/0.1 N)^2

A larger impedance b stiffens the link, 2b/tau, and makes it heavier, b tau/2: there is an optimum.

Where a scenario is not linear, radii, stiffnesses and masses are those of its nearest linear one
(:mod:`pmwvc_analysis.models.linear`); passivity, aliasing and noise are those of the scenario.
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmwvc_analysis.models import stability
from pmwvc_analysis.models.any_delay import any_delay
from pmwvc_analysis.models.linear import axes_of, outside, relative
from pmwvc_analysis.models.linearize import stable
from pmwvc_analysis.prediction import lag, prediction
from pmwvc_analysis.transparency.transparency import Rendering, transparency, untouched
from pmwvc_analysis.verdicts import passivity
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.params import FilterParams
from pmwvc_core.params.names import flattened
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.wave.impedance import MatrixImpedance

NOTICED_N = 0.1  # [N] force noise, root mean square, that counts as one difference
# What a choice changes, by the beginnings of names, and what is said even where nothing changes.
IMPEDANCES = ("master.impedance", "master.contact_impedance", "server.impedance")
SAMPLED = ("master.filter", "master.hold")
ALWAYS = ("master.impedance", "master.filter.kind", "master.hold")
NOTICED = math.log(1.23)  # just noticeable ratio of stiffnesses and of weights
ENCODER_STEP_M = 1e-5  # taken where the scenario's device is exact
STABLE, NOT_JUDGED = "stable", "stability not judged"
LEAST_S, LONGEST_S = 4.0, 12.0  # of a session that is simulated
USER_TICKS = 48_000  # that are simulated, if the session is not too short then: some 1 s
COUPLED = 8  # of them for a tick with axes that are coupled


@dataclass(frozen=True)
class Choice:
    """Impedance, that in contact (None: the same) [N s/m], filter and hold (strict: as given) for
    every user; ``as_given`` leaves the scenario as it is, ``impedance`` is then that of the first
    master's first axis.
    """

    impedance: float
    filter: FilterParams
    hold: str
    contact: float | None = None
    as_given: bool = False

    def times(self, factor: float, bounds: tuple[float, float]) -> "Choice":
        """Return a choice with so many times the impedances, within bounds."""
        b = float(np.clip(factor * self.impedance, *bounds))
        touching = self.contact and float(np.clip(factor * self.contact, *bounds))
        return dataclasses.replace(self, impedance=b, contact=touching)

    def settings(self, scenario: Scenario) -> dict[str, float | str]:
        """Return what gives a scenario this choice, by name; no impedance that is no number."""
        ends = {b for user in scenario.users for b in (user.impedance, user.server_impedance)}
        given = self.as_given and (len(ends) > 1 or isinstance(ends.pop(), MatrixImpedance))
        names = (IMPEDANCES if not given else ()) + (SAMPLED if not scenario.strict else ())
        chosen, default, *before = (
            flattened("master", user.master) | flattened("server", user.contact)
            for user in (self._for(scenario.users[0]), User(""), *scenario.users)
        )
        return {
            name: "null" if value is None else value
            for name, value in chosen.items()
            if name.startswith(names)
            and (name in ALWAYS or {default[name], *(each[name] for each in before)} != {value})
        }

    def _for(self, user: User) -> User:
        """Return a user with this choice, impedances to 0.01 N s/m."""
        master = dataclasses.replace(
            user.master,
            impedance=round(self.impedance, 2),
            impedance_matrix="",
            contact_impedance=self.contact and round(self.contact, 2),
            filter=self.filter,
            hold=self.hold,
        )
        contact = dataclasses.replace(user.contact, impedance=None, impedance_matrix="")
        return dataclasses.replace(user, master=master, contact=contact)

    def applied(self, scenario: Scenario) -> Scenario:
        """Return the scenario with this choice for every user, the same at both ends."""
        if self.as_given:
            return scenario
        return dataclasses.replace(scenario, users=tuple(map(self._for, scenario.users)))


@dataclass(frozen=True)
class Rating:
    """Rating of a choice for the first user; feel is None where the loop is not stable."""

    choice: Choice
    stable: bool  # in touch and free
    spectral_radius: float  # in touch
    free_radius: float  # with nothing touched
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
    """Return what a choice does for a scenario, along the first axis; raises as the model."""
    chosen = choice.applied(scenario)
    user = chosen.users[0]
    near = relative(chosen)
    linear = near.scenario if near else chosen
    of_both = (stability.radii(of, live=live)[0] for of in (linear, untouched(linear)))
    in_touch, free = map(float, of_both)
    own, k_ideal, mass_ideal = Rendering(), None, None
    if stable(max(in_touch, free)):
        found = transparency(linear, np.ones(1), live=live)  # at rest is all
        own = found.rendered
        # What an ideal that is not stable itself (a wall without damping, sampled) leaves unknown
        # is that of the contact or the device by itself.
        k_ideal, mass_ideal = found.ideal.k_felt, found.ideal.mass_felt
        k_ideal = k_ideal if k_ideal is not None else float(user.contact.contact_stiffness) or None
        mass_ideal = mass_ideal if mass_ideal is not None else float(user.device.mass) or None
    noise, cost, proof = noise_n(scenario, choice.impedance), None, any_delay(chosen)
    k_ratio = _ratio(own.k_felt, k_ideal, 0.0)
    m_ratio = _ratio(own.mass_felt, mass_ideal, float(user.operator.mass))
    if k_ratio and m_ratio and not own.k_felt is own.mass_felt is None:
        cost = float(cost_of(k_ratio, m_ratio, noise if velocity_step(scenario) else 0.0))
    return Rating(
        choice=choice,
        stable=stable(max(in_touch, free)),
        spectral_radius=in_touch,
        free_radius=free,
        passive=proof is not None and proof.proved,
        aliasing_gain=None if chosen.strict else prediction.aliasing_gain(user),
        lag_s=None if outside(chosen) else lag.lag_s(user, chosen, live=live),
        k_felt=own.k_felt,
        k_ideal=k_ideal,
        mass_felt=own.mass_felt,
        mass_ideal=mass_ideal,
        noise_n=noise,
        cost=cost,
    )


def velocity_step(scenario: Scenario) -> float | None:
    """Return the largest velocity of one encoder step [m/s]; None where velocities are exact."""
    steps = [
        float(user.device.encoder_step_m) / float(user.master.tick_s)
        for user in scenario.users
        if user.device.differences or not user.device.is_simulated
    ]
    return max(steps, default=0.0) or None


def noise_n(scenario: Scenario, impedance: Any) -> Any:
    """Return the force noise of the encoder's steps [N], root mean square."""
    steps = [float(user.device.encoder_step_m) for user in scenario.users]
    step = max(steps) or ENCODER_STEP_M
    return impedance * step / (math.sqrt(6.0) * scenario.tick_s)


def cost_of(k_ratio: Any, m_ratio: Any, noise_n: Any = 0.0) -> Any:
    """Return the distance from the ideal in just-noticeable differences; arrays as well."""
    ratios = np.hypot(np.log(k_ratio), np.log(m_ratio)) / NOTICED
    return np.hypot(ratios, noise_n / NOTICED_N)


def _ratio(felt: float | None, ideal: float | None, more: float) -> float | None:
    """Return rendered to ideal, each with more: 1 without an ideal, else None without rendered."""
    if not ideal:
        return 1.0
    return max((felt + more) / (ideal + more), 1e-9) if felt else None


def session_of(scenario: Scenario) -> Scenario:
    """Return the session that a choice is judged by, of equal axes the one along which hands
    press.
    """
    if axes_of(scenario) == 1:
        task = dataclasses.replace(scenario.task, sideways_m=0.0, upwards_m=0.0)
        scenario = dataclasses.replace(scenario, dof=1, task=task)
    ticks = USER_TICKS / len(scenario.users) / (COUPLED if scenario.dof > 1 else 1)
    longest_s = min(LONGEST_S, max(LEAST_S, ticks * scenario.tick_s), scenario.duration_s)
    return dataclasses.replace(scenario, duration_s=longest_s)


def judged(scenario: Scenario, row: Rating) -> Rating:
    """Return the rating of a choice with the verdicts of its session in virtual time."""
    session = session_of(row.choice.applied(scenario))
    traces = simulate_one(session)
    found, ports = verdict(traces, session), passivity.passivity(traces, session, None)
    owners = dict.fromkeys(each.owner for each in ports.ports if each.passive is False)
    words = [f"{owner}: {passivity.verdict(ports, owner)}" for owner in owners]
    return dataclasses.replace(
        row,
        simulated=STABLE if found.stable else found.instability or NOT_JUDGED,
        simulated_passivity="; ".join(words) or None,
    )
