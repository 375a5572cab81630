# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The lag of a wave link and how it is rendered: stiffness, mass, distance of device and avatar.

The lag tau, once around (filter, rate drop, network both ways, hold), acts like a spring 2 b/tau
and a mass b tau/2 at the device, b the master's impedance. Ends of different impedance are a
lossless transformer. With n^2 = b_s/b_m, for slow motion,

    F_s = n F_m,                            x_m = n x_s + F_m tau/(2 b_m),
    1/k_felt = n^2/K + tau/(2 b_m),         mass_felt = b_m tau/2,

so the device moves n times as far as its avatar: only for n = 1 is the distance between them
F tau/(2 b), the lead of a steady press.

With ``one_step_delay`` the avatar moves by the force of the step before: once the force F_s has
been built up it stands F_s T_VE/b_s further in than its waves give, at the device n F_s T_VE/b_s =
F_m T_VE/b_m: a lag of -2 T_VE, on either channel. Where that is more than the waves lag, the
device stands behind its avatar and renders more than the contact's stiffness. Nothing touched
there is no force, and the lag is that of the waves.

A zero-order hold comes back as steps through device and filter, which is sampled at their end and
not at their mean. While a wave rises evenly, tick j of a frame is j - (M-1)/2 ticks older than the
mean; what device and filter leave of that at a sample makes the lag longer where something is
touched, and shorter by as much where nothing is: the wave comes back with the other sign. Nothing
is left behind ``integrate_and_dump``.

On the strict channel the playouts make the lag: :mod:`.playout_lag`.

Equations: docs/theory.md 11.1, 11.2, 11.3, 11.4, 11.5.
"""

import math

import numpy as np

from pmwvc_analysis.models.links import Times, delay_ticks, hyperperiod_ticks, times_of
from pmwvc_analysis.prediction.environment import decodes_late
from pmwvc_analysis.prediction.playout_lag import strict_lag_s
from pmwvc_core.law.motion import motion
from pmwvc_core.network.effects import active, is_random, mean_s
from pmwvc_core.params import DeviceParams, LinkParams, MasterParams
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.wave.design import aliasing
from pmwvc_core.wave.design.filter_design import response
from pmwvc_core.wave.design.velocity_filter_design import slow_lags
from pmwvc_core.wave.impedance import first_axis, transformation

RATIO_TOLERANCE = 1e-9  # of impedances: below it the ends are equal


def series_stiffness(contact: float, impedance: float, tau: float, ratio: float = 1.0) -> float:
    """Return contact and link in series [N/m]; ``ratio`` is n^2 = b_s/b_m."""
    if contact <= 0.0:
        return 0.0
    return 1.0 / (ratio / contact + tau / (2.0 * impedance))


def rendered_stiffness(user: User, tau: float) -> float:
    """Return the stiffness at a user's device, the contact being known [N/m]."""
    contact, b = float(user.contact.contact_stiffness), first_axis(user.impedance)
    return series_stiffness(contact, b, tau, transformer(user))


def rendered_mass(user: User, scenario: Scenario, *, live: bool) -> float:
    """Return the mass of a user's link, b tau/2 with nothing touched [kg]."""
    tau = lag_s(user, scenario, live=live, touching=False)
    return first_axis(user.impedance) * tau / 2.0


def transformer(user: User) -> float:
    """Return n^2 = b_s/b_m of a user's ends, for a force along the first axis."""
    return transformation(user.impedance, user.server_impedance)


def lag_decides(user: User, scenario: Scenario) -> bool:
    """Tell whether the lag alone decides what is rendered: not with a local model that answers at
    once, nor with position feedback, nor where the contact is not known.
    """
    master, environment = user.master, scenario.environment
    if not lag_is_known(scenario) or environment.linear != environment.name:
        return False
    return not master.bank.as_published and not master.position.is_on


def lag_is_known(scenario: Scenario) -> bool:
    """Tell whether the lag of the server's coupling is known: of a linear one of the library."""
    coupling = scenario.coupling
    return coupling.name in COUPLINGS.library and coupling.linear == coupling.name


def expected(user: User) -> str:
    """Return in words that a round trip is an expected one; empty where nothing is drawn."""
    drawn = is_random(user.link_up) or is_random(user.link_down)
    return " (expected; jitter and loss decide it)" if drawn else ""


def round_trip_words(user: User, scenario: Scenario, *, live: bool) -> str:
    """Return the round trip of a user's waves in words, and by how much its avatar leads."""
    lead = lead_s(scenario)
    tau = lag_s(user, scenario, live=live) + lead
    text = f"round trip {tau * 1e3:.1f} ms{expected(user)}"
    if not lead:
        return text
    return f"{text}, less {lead * 1e3:.1f} ms: its avatar moves by the force of the step before"


def link_words(user: User, scenario: Scenario, *, live: bool) -> str:
    """Return what the lag is rendered as, in words: a spring and a mass; where the avatar leads by
    more than the waves lag, what the device renders instead.
    """
    tau, b = lag_s(user, scenario, live=live), first_axis(user.impedance)
    mass = rendered_mass(user, scenario, live=live)
    stiffness, contact = rendered_stiffness(user, tau), float(user.contact.contact_stiffness)
    if tau > 0.0:
        return (
            f"the link acts like a spring of {2.0 * b / tau:.0f} N/m and a mass of {mass:.2f} kg "
            f"(rendered stiffness {stiffness:.0f} N/m)"
        )
    behind = f"the device stands {-tau / (2.0 * b) * 1e3:.2f} mm per newton behind its avatar"
    rendered = f"renders {stiffness:.0f} N/m, the contact {contact:.0f} N/m"
    if not 0.0 < stiffness < math.inf:
        rendered = f"its rendered stiffness is not known (contact {contact:.0f} N/m)"
    return f"{behind} and {rendered}; nothing touched, the link acts like a mass of {mass:.2f} kg"


def lag_s(user: User, scenario: Scenario, *, live: bool, touching: bool = True) -> float:
    """Return tau, the lag of slow motion once around the wave path [s]; a velocity filter makes
    another one of it where nothing is touched, and without a force nothing leads
    (:func:`lead_s`). A complementary bank adds 1/a each way.
    """
    if scenario.strict:
        lag = strict_lag_s(user, scenario, live=live)
    else:
        lag = _plain_lag_s(user, scenario, live=live, touching=touching)
    return float(lag - (lead_s(scenario) if touching else 0.0))


def lead_s(scenario: Scenario) -> float:
    """Return by how much less the waves lag in contact because the avatar is moved by the force of
    the step before [s]; see module.
    """
    return 2.0 * scenario.server.period_s if decodes_late(scenario) else 0.0


def _plain_lag_s(user: User, scenario: Scenario, *, live: bool, touching: bool) -> float:
    """Return the lag of filter, rate drop, network and hold [s]."""
    master = user.master
    lag = aliasing.delay_of(master.filter, tick_s=master.tick_s, rate_drop=master.rate_drop)
    lag += slow_lags(master)[0 if touching else 1]
    lag += master.bank.lag_s
    lag += master.tick_s  # the packet leaves one tick after the output it carries
    hold = master.frame_s - master.tick_s
    lag += hold if master.ramps else hold / 2.0
    phase = times_of(user, scenario, live=live)[1].phase
    steps = step_lag_s(master, user.device, first_axis(user.impedance), phase)
    lag += steps if touching else -steps
    return float(lag + network_s(user, scenario, live=live))


def step_lag_s(
    master: MasterParams, device: DeviceParams, impedance: float, phase: int = 0
) -> float:
    """Return by how much the steps of a zero-order hold make the lag longer in contact [s].

    ``phase``: tick of the frame at which the hold steps; the filter is sampled at its start.
    Without velocity filter and filter bank; with one of them it is not known and taken as zero.
    """
    m, tick_s = master.rate_drop, master.tick_s
    plain = not (master.velocity_filter.is_on or master.bank.is_on)
    if master.ramps or not plain or impedance * tick_s / device.mass >= 2.0:
        return 0.0
    older = 0.5 * (m - 1) - (np.arange(m) - phase) % m  # than the mean: a wave of period M
    hertz = np.arange(m) / (m * tick_s)
    z = np.exp(2j * np.pi * hertz * tick_s)
    moves = motion(device.mass, device.damping, tick_s)
    admitted = moves.f_xd / (z - moves.xd_xd + moves.f_xd * impedance)
    passed = response(master.filter, hertz, tick_s=tick_s, rate_drop=m)
    left = np.fft.ifft(np.fft.fft(older) * (2.0 * impedance * admitted - 1.0) * passed)
    return float(left[-1].real) * tick_s


def network_s(user: User, scenario: Scenario, *, live: bool) -> float:
    """Return how old packets are when they are taken, both ways together [s].

    Receivers take the newest packet at their own times; the mean counts. With jitter the mean is
    half a period on top of the mean delay.
    """
    ticks = hyperperiod_ticks(scenario)
    sent, taken, served = times_of(user, scenario, live=live)
    up = _age_s(user.link_up, sent, served, ticks, scenario.tick_s, live=live)
    return up + _age_s(user.link_down, served, taken, ticks, scenario.tick_s, live=live)


def _age_s(
    link: LinkParams, sent: Times, taken: Times, ticks: int, tick_s: float, *, live: bool
) -> float:
    if any(effect.spreads for effect in active(link)):
        least = (taken.phase - sent.phase) * tick_s if live else 0.0
        return max(least, mean_s(link) + 0.5 * taken.period * tick_s)
    delay = delay_ticks(link, tick_s=tick_s, live=live)
    looks = np.arange(taken.phase, taken.phase + min(ticks, 20000), taken.period)
    ages = [look - sent.last(look - delay) for look in looks.tolist()]
    return float(np.mean(ages)) * tick_s
