# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The lag of a wave link and how it is rendered: stiffness, mass, distance of device and avatar.

The lag tau, once around (filter, rate drop, network both ways, hold), acts like a spring 2 b/tau
and a mass b tau/2 at the device, b the master's impedance. Ends of different impedance are a
lossless transformer. With n^2 = b_s/b_m, for slow motion,

    F_s = n F_m,                            x_m = n x_s + F_m tau/(2 b_m),
    1/k_felt = n^2/K + tau/(2 b_m),         mass_felt = b_m tau/2.

With ``one_step_delay`` the avatar moves by the force of the step before: in contact it stands F_s
T_VE/b_s further in than its waves give, at the device F_m T_VE/b_m: a lag of -2 T_VE, on either
channel. Where that is more than the waves lag, the device stands behind its avatar and renders
more than the contact's stiffness.

A zero-order hold comes back as steps through device and filter, which is sampled at their end.
While a wave rises evenly, tick j of a frame is j - (M-1)/2 ticks older than the mean; what device
and filter leave of that at a sample makes the lag longer in contact, and shorter by as much where
nothing is touched: the wave comes back with the other sign.

On the strict channel, without filter, rate drop and hold, a playout follows how late packets come:
by the greatest age a of the newest packet at a step of the server, and the delay d down, where
delays are constant. A step's wave is taken and answered as a whole, half a step late each way, and
the master's ramp is the mean of N = T_VE/T_c ticks:

    tau = a + d + T_VE + (N - 1)/2 T_c,    with nothing touched T_c less

Else it settles at the mean lateness: at the mean delay, and with a ratio p of packets lost one by
one 2 p/(1 - p) packets later, as a segment counts by its length. A deadband adds the time for
which a frame waits at most. Bursts are not counted. Where the impedance follows contact, b is that
of contact for what is felt there, and that of free motion for the mass.

Equations: docs/theory.md 11.1, 11.2, 11.3, 11.4, 11.5, 17.7.
"""

import math

import numpy as np

from pmwvc_analysis.models.links import delay_ticks, hyperperiod_ticks, link_times
from pmwvc_analysis.prediction.environment import decodes_late
from pmwvc_core.law.motion import motion
from pmwvc_core.network.effects import active, mean_s
from pmwvc_core.params import DeadbandParams, DeviceParams, LinkParams, MasterParams
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.wave import aliasing
from pmwvc_core.wave.filter_design import response
from pmwvc_core.wave.impedance import first_axis, transformation
from pmwvc_core.wave.velocity_filter_design import slow_lags

RATIO_TOLERANCE = 1e-9  # of impedances: below it the ends are equal
MOST_LOOKS = 20000  # ticks of a hyperperiod over which ages are averaged


def lag_is_known(scenario: Scenario) -> bool:
    """Tell whether the lag of the server's coupling is known: of a linear one of the library."""
    coupling = scenario.coupling
    return coupling.name in COUPLINGS.library and coupling.linear == coupling.name


def lag_decides(user: User, scenario: Scenario) -> bool:
    """Tell whether the lag alone decides what is rendered: not with a local model that answers at
    once, nor with position feedback, nor where the contact is not known.
    """
    master, environment = user.master, scenario.environment
    if not lag_is_known(scenario) or environment.linear != environment.name:
        return False
    return not master.bank.as_published and not master.position.is_on


def transformer(user: User) -> float:
    """Return n^2 = b_s/b_m of a user's ends, for a force along the first axis."""
    return transformation(user.impedance, user.server_impedance)


def series_stiffness(contact: float, impedance: float, tau: float, ratio: float = 1.0) -> float:
    """Return contact and link in series [N/m]; ``ratio`` is n^2 = b_s/b_m."""
    return 1.0 / (ratio / contact + tau / (2.0 * impedance)) if contact > 0.0 else 0.0


def rendered_stiffness(user: User, tau: float) -> float:
    """Return the stiffness at a user's device, the contact being known [N/m]."""
    contact, b = float(user.contact.contact_stiffness), first_axis(user.in_contact.impedance)
    return series_stiffness(contact, b, tau, transformer(user))


def rendered_mass(user: User, scenario: Scenario, *, live: bool) -> float:
    """Return the mass of a user's link, b tau/2 with nothing touched [kg]."""
    return first_axis(user.impedance) * lag_s(user, scenario, live=live, touching=False) / 2.0


def lead_s(scenario: Scenario) -> float:
    """Return by how much less waves lag in contact [s]: the avatar moves by the force before."""
    return 2.0 * scenario.server.period_s if decodes_late(scenario) else 0.0


def lag_s(user: User, scenario: Scenario, *, live: bool, touching: bool = True) -> float:
    """Return tau, the lag of slow motion once around the wave path [s]; a velocity filter makes
    another one of it where nothing is touched, and without a force nothing leads
    (:func:`lead_s`). A complementary bank adds 1/a each way.
    """
    master, lead = user.master, lead_s(scenario) if touching else 0.0
    if scenario.strict:
        early_s = 0.0 if touching or master.bank.is_on else master.tick_s
        return float(strict_lag_s(user, scenario, live=live) - lead - early_s)
    lag = aliasing.delay_of(master.filter, tick_s=master.tick_s, rate_drop=master.rate_drop)
    lag += slow_lags(master)[0 if touching else 1] + master.bank.lag_s
    lag += master.tick_s  # the packet leaves one tick after the output it carries
    hold = master.frame_s - master.tick_s
    lag += hold if master.ramps else hold / 2.0
    phase = link_times(user, scenario, live=live).taken.phase
    steps = step_lag_s(master, user.device, first_axis(user.impedance), phase)
    lag += steps if touching else -steps
    return float(lag + network_s(user, scenario, live=live) - lead)


def step_lag_s(
    master: MasterParams, device: DeviceParams, impedance: float, phase: int = 0
) -> float:
    """Return by how much the steps of a zero-order hold make the lag longer in contact [s].

    ``phase``: tick of the frame at which the hold steps; the filter is sampled at its start.
    With velocity filter or filter bank it is not known and taken as zero.
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
    """Return how old packets are on average when they are taken, both ways together [s]: receivers
    take the newest one at their own times, half a period after the mean delay with jitter.
    """
    ticks, tick_s, age_s = min(hyperperiod_ticks(scenario), MOST_LOOKS), scenario.tick_s, 0.0
    up, down, taken = link_times(user, scenario, live=live)
    for link, way in ((user.link_up, up), (user.link_down, down._replace(looked=taken))):
        if any(effect.spreads for effect in active(link)):
            least = (way.looked.phase - way.sent.phase) * tick_s if live else 0.0
            age_s += max(least, mean_s(link) + 0.5 * way.looked.period * tick_s)
        else:
            age_s += float(np.mean(way.ages(ticks))) * tick_s
    return age_s


def strict_lag_s(user: User, scenario: Scenario, *, live: bool) -> float:
    """Return tau on the strict channel [s]."""
    tick_s, period_s, frame_s = scenario.tick_s, scenario.server.period_s, user.master.frame_s
    delay = round(_delay_s(user.link_up, tick_s, live=live) / tick_s)
    up = link_times(user, scenario, live=live).up._replace(delay=delay)
    lag = max(up.ages(hyperperiod_ticks(scenario))) * tick_s
    lag += _delay_s(user.link_down, tick_s, live=live) + 0.5 * (period_s - tick_s)
    lag += _lost_s(user.link_up, frame_s) + _lost_s(user.link_down, period_s)
    lag += _held_back_s(user.master.deadband, frame_s)
    lag += _held_back_s(user.contact.deadband, period_s)
    return lag + period_s + user.master.bank.lag_s


def _held_back_s(deadband: DeadbandParams, interval_s: float) -> float:
    """Return how long a deadband lets a frame wait for its packet at most [s]."""
    frames = math.floor(deadband.longest_s / interval_s + 1e-9) if deadband.is_on else 1
    return max(frames - 1, 0) * interval_s


def _delay_s(link: LinkParams, tick_s: float, *, live: bool) -> float:
    """Return the delay that a playout follows, where it is constant in whole ticks [s]."""
    if any(effect.spreads for effect in active(link)):
        return mean_s(link)
    return delay_ticks(link, tick_s=tick_s, live=live) * tick_s


def _lost_s(link: LinkParams, interval_s: float) -> float:
    """Return what packets that are lost one by one add to the lag that a playout follows [s]."""
    loss = float(np.max(link.loss))
    return interval_s * 2.0 * loss / (1.0 - loss) if loss < 1.0 else 0.0
