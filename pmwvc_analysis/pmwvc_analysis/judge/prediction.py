# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a scenario's numbers promise: stability, aliasing, and how the link feels.

Stable or not, spectral radius and largest contact stiffness come from the exact model of the loop
(:mod:`pmwvc_analysis.models`): hands off, all contacts touching. What is not linear has no such
model; then only passivity of all parts is a promise.

The lag tau of the wave path, once around (network both ways, anti-aliasing filter, hold), acts
like a spring K = 2b/tau and a mass M = b tau/2 in series with what is touched:

    1/k_felt = 1/K_contact + tau/(2b),          mass_felt = b tau/2.

In a steady press with force F the device stands F tau/(2b) ahead of its avatar, besides what the
contact yields. With ``one_step_delay`` the avatar moves by the force of the step before: once the
force F has been built up it stands F T_VE/b further in than its waves say, which counts as a lag
of -2 T_VE.

Where a matrix stands for b, k_felt and mass_felt are those of a force along the first axis, and
what has to hold for b holds for its smallest or largest eigenvalue.
"""

import functools
import math
from typing import NamedTuple

from pmwvc_analysis.judge import prediction_environment
from pmwvc_analysis.judge.prediction_environment import decodes_late
from pmwvc_analysis.models import stability
from pmwvc_analysis.models.server import UNKNOWN
from pmwvc_core.errors import PmwvcError
from pmwvc_core.params import LinkParams
from pmwvc_core.simulation.scenario import Scenario, User
from pmwvc_core.wave import aliasing
from pmwvc_core.wave.content import has_waves
from pmwvc_core.wave.impedance import first_axis, largest, smallest
from pmwvc_core.wave.velocity_filter_response import slow_lags

# The server steps that much into the master's frame; the master takes the answer as much later.
LIVE_PHASE_S = 0.002
ALIASING_BOUND = 1.1
# Compensation, environment and decoding that are one_step_delay.
UNTREATED = ("none", "wall", "late")


class Exact(NamedTuple):
    """What the exact model says."""

    spectral_radius: float
    stable: bool
    limit: stability.Limit


@functools.lru_cache(maxsize=64)
def exact(scenario: Scenario, *, live: bool) -> Exact | None:
    """Return what the exact model says; None where there is none."""
    try:
        radius = float(stability.radii(scenario, live=live)[0])
        limit = stability.k_max(scenario, live=live)
    except PmwvcError:
        return None
    return Exact(radius, stability.stable(radius), limit)


def prediction(scenario: Scenario, *, live: bool) -> dict[str, float | bool | None]:
    """Return the ``prediction`` of a summary; the user who is worst off counts.

    ``k_max`` is None where no contact stiffness up to ``stability.BOUND`` is unstable, and all
    three of ``spectral_radius``, ``stable`` and ``k_max`` where there is no exact model (unless
    the parts are passive one by one and no environment will be limited: then ``stable`` is
    True all the same). ``k_felt`` and ``mass_felt`` are None where more than the lag decides them.
    """
    model = exact(scenario, live=live)
    values: dict[str, float | bool | None] = dict.fromkeys(
        (
            "spectral_radius",
            "stable",
            "k_max",
            "aliasing_gain",
            "k_felt",
            "mass_felt",
            "environment_limited",
        )
    )
    if model is not None:
        values["spectral_radius"], values["stable"] = model.spectral_radius, model.stable
        values["k_max"] = model.limit.first
    if not has_waves(scenario.controller):
        return values
    lags = [lag_s(user, scenario, live=live) for user in scenario.users]
    impedances = [first_axis(user.impedance) for user in scenario.users]
    stiffness = [
        felt_stiffness(float(user.contact.contact_stiffness), b, tau)
        for user, b, tau in zip(scenario.users, impedances, lags, strict=True)
    ]
    limited = values["environment_limited"] = prediction_environment.limited(scenario)
    if model is None and passive(scenario) and limited is False:
        values["stable"] = True
    values["aliasing_gain"] = max(aliasing_gain(user) for user in scenario.users)
    if limited or not all(feels_as_its_lag(user, scenario) for user in scenario.users):
        return values
    values["k_felt"] = min(stiffness)
    free = [lag_s(user, scenario, live=live, touching=False) for user in scenario.users]
    values["mass_felt"] = max(b * tau / 2.0 for b, tau in zip(impedances, free, strict=True))
    return values


def passive(scenario: Scenario) -> bool:
    """Tell whether all parts are passive, each for itself: stable at any delay, with any hand."""
    return has_waves(scenario.controller) and all(
        aliasing_gain(user) <= ALIASING_BOUND and parts_passive(user, scenario)
        for user in scenario.users
    )


def aliasing_gain(user: User) -> float:
    """Return the largest ratio of a packet's energy to that of the wave it samples."""
    master = user.master
    return float(
        aliasing.worst_case_gain(master.filter, tick_s=master.tick_s, rate_drop=master.rate_drop)
    )


def parts_passive(user: User, scenario: Scenario) -> bool:
    """Tell whether device and server port are passive, each for itself.

    Held device force: stable at a matched port for b T_c/m < 2. Velocity filter: only the
    complementary one is; for the others anti-aliasing filter and environment have to pay. Filter
    bank: likewise. Position feedback: not where nothing pays for it. Server:
    ``implicit`` conserves energy exactly; a ledger gives back no more than it got, but for its
    allowance; ``one_step_delay``, and a wall that is unknown, are passive for K T_VE + 2B <= b
    (backward Euler). The other couplings have no such bound.
    """
    if largest(user.impedance) * user.master.tick_s / float(user.device.mass) >= 2.0:
        return False
    if user.master.velocity_filter.kind in ("exact", "equivalent"):
        return False
    position = user.master.position
    if position.is_on and position.feedback == "printed":
        return False
    if user.master.bank.kind == "dissertation":
        return False
    server = scenario.server
    if server.coupling == "unknown" and server.compensation == "ledger":
        return bool(min(server.allowance_w, server.allowance_j) == 0.0)
    return server.coupling == "implicit" or one_step_bound(user, scenario) is True


def feels_as_its_lag(user: User, scenario: Scenario) -> bool:
    """Tell whether the lag alone decides what the link feels like: not with a local model that
    answers at once, nor with position feedback, nor where the contact is not known.
    """
    master, server = user.master, scenario.server
    if server.coupling == "unknown" and server.environment not in UNKNOWN:
        return False
    return master.bank.kind != "dissertation" and not master.position.is_on


def one_step_bound(user: User, scenario: Scenario) -> bool | None:
    """Tell whether K T_VE + 2B <= b holds, None where it does not apply."""
    server = scenario.server
    treated = (server.compensation, server.environment, server.decoding) != UNTREATED
    if server.coupling == "unknown" and treated:
        return None
    if not decodes_late(user, scenario) or server.integrator != "backward_euler":
        return None
    return least_impedance(user, scenario) <= smallest(user.server_impedance)


def least_impedance(user: User, scenario: Scenario) -> float:
    """Return K T_VE + 2B, with which decoding a step late is passive [N s/m]."""
    contact = user.contact
    stiff = float(contact.contact_stiffness) * scenario.server.period_s
    return stiff + 2.0 * float(contact.contact_damping)


def felt_stiffness(contact: float, impedance: float, tau: float) -> float:
    """Return contact and link in series [N/m]."""
    if contact <= 0.0:
        return 0.0
    return 1.0 / (1.0 / contact + tau / (2.0 * impedance))


def lag_s(user: User, scenario: Scenario, *, live: bool, touching: bool = True) -> float:
    """Return tau, the lag of slow motion once around the wave path [s]; a velocity filter makes
    another one of it where nothing is touched. A complementary bank adds 1/a each way.
    """
    master = user.master
    lag = aliasing.delay_of(master.filter, tick_s=master.tick_s, rate_drop=master.rate_drop)
    lag += slow_lags(master)[0 if touching else 1]
    if master.bank.kind == "complementary":
        lag += 2.0 / float(master.bank.split_rad_s)
    lag += master.tick_s  # the packet leaves one tick after the output it carries
    hold = master.frame_s - master.tick_s
    lag += hold if master.hold == "foh" else hold / 2.0
    phase = LIVE_PHASE_S if live else 0.0
    lag += network_s(user.link_up, scenario.server.period_s, phase)
    lag += network_s(user.link_down, master.frame_s, phase)
    if decodes_late(user, scenario):  # the avatar runs F T/b ahead: see module
        lag -= 2.0 * scenario.server.period_s
    return float(lag)


def network_s(link: LinkParams, period_s: float, phase_s: float) -> float:
    """Return how old a packet is when its receiver looks at it [s].

    Receivers look once a period, ``phase_s`` into it. With jitter the mean: half a period on top
    of the delay.
    """
    if link.jitter != "none":
        return max(phase_s, link.delay_s + period_s / 2.0)
    looks = math.ceil(max(0.0, (link.delay_s - phase_s) / period_s) - 1e-6)
    return phase_s + looks * period_s
