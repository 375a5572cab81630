# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions that measure what a method renders on a network, the same for all methods.

======================  ===========================================================================
``z_width``,            share of 45 walls (:mod:`benchmark.walls`) that are rendered, and of those
``z_width_passive``     with all ports passive
``stiffness_max_n_m``   largest stiffness of a wall (contact damping 10 N s/m) up to which all are
                        rendered, to 13 %; 0: not even the softest
``stiffness_n_m``       rendered for a wall of 500 N/m that pulls and pushes: Re F/x to a chirp of
                        1 N, mean of 0.2 to 0.5 Hz
``mass_kg``,            rendered with nothing touched, device included
``damping_n_s_m``       (:func:`pmwvc_analysis.compare.probes.free_space`); not asked beyond half a
                        second of round trip
``transparency``        mean of |log10 |Z/Z_direct|| over log frequency, 0.2 to 20 Hz, of that
                        wall, where the coherence is at least 0.9, which has to be half of the
                        band; Z_direct: direct coupling at every tick without delay
``drift_m_s``           slope of device less avatar over a hold of the cube, the larger of both
``held_apart_m``        device less avatar in the last second of that hold, likewise
``completion_s``        how long a cube that is carried once takes, from the first motion of its
                        target until it is within 5 mm of it for good
======================  ===========================================================================

What could not be measured has failed: no stiffness and no walls (0), all others infinite.
"""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from benchmark.carry import placed_s
from benchmark.methods import Settings
from benchmark.trial import Trial, scenario_of
from benchmark.walls import GRID, Grid, wall, walls
from pmwvc_analysis.compare.probes import free_space
from pmwvc_analysis.compare.settings import RESTLESS
from pmwvc_analysis.traces.apart import apart
from pmwvc_analysis.transparency.measured import TRUSTED, measure
from pmwvc_analysis.transparency.transparency import ideal_of, transparency
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.errors import PmwvcError
from pmwvc_core.network.effects import mean_s
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one

CHIRP = (
    *("task.kind=free", "operator.kind=chirp", "operator.force=1", "operator.frequency_hz=0.2"),
    *("operator.frequency_end_hz=20", "operator.sweep_s=20", "server.contact=bilateral"),
    *("server.gap_m=0", "server.contact_stiffness=500"),
)
CHIRP_S = 24.0
BAND_HZ, PARTS = (0.2, 20.0), 20
SLOW_HZ = 0.5
SETTLED_S = 5.0  # from when on a hold counts
HOLD = ("task.kind=hold",)
ONCE = ("task.move_rise_s=1", "task.rest_s=1000")  # a carry that ends
CARRY_S, ROUND_TRIPS = 10.0, 8.0  # its duration, and for each round trip more


@dataclass(frozen=True)
class Probe:
    """A measurement to make: a method on a network."""

    method: str
    settings: Settings
    network: str
    seed: int
    hold_s: float


@dataclass(frozen=True)
class Rendered:
    """The result of a probe; see the module."""

    z_width: float
    z_width_passive: float
    stiffness_max_n_m: float
    stiffness_n_m: float
    mass_kg: float
    damping_n_s_m: float
    transparency: float
    drift_m_s: float
    held_apart_m: float
    completion_s: float


def rendered(probe: Probe, grid: Grid = GRID) -> Rendered:
    """Run all sessions of a probe, with the walls of a grid."""
    free = free_space(_carry(probe, (), 1.0))
    stiffness, error = wall_rendered(probe)
    drift_m_s, held_apart_m = _held(probe)
    found = walls(probe.settings, probe.network, probe.seed, grid)
    return Rendered(
        z_width=found.rendered,
        z_width_passive=found.rendered_passive,
        stiffness_max_n_m=found.stiffness_max_n_m,
        stiffness_n_m=stiffness,
        mass_kg=free.mass_kg if free else math.inf,
        damping_n_s_m=free.damping_n_s_m if free else math.inf,
        transparency=error,
        drift_m_s=drift_m_s,
        held_apart_m=held_apart_m,
        completion_s=_completed(probe),
    )


def _chirped(probe: Probe) -> Scenario:
    return wall((*probe.settings, *CHIRP), probe.network, probe.seed, CHIRP_S)


def _carry(probe: Probe, settings: Settings, duration_s: float) -> Scenario:
    chosen = (*probe.settings, *settings)
    return scenario_of(Trial(probe.method, chosen, probe.network, probe.seed, duration_s))


def wall_rendered(probe: Probe) -> tuple[float, float]:
    """Return stiffness [N/m] and error of the impedance [decades] of a wall."""
    scenario = _chirped(probe)
    direct = ideal_of(_chirped(dataclasses.replace(probe, settings=("controller=direct",))))
    traces = simulate_one(scenario)
    nothing = 0.0, math.inf
    if not np.isfinite(traces.users[0].x_m).all():
        return nothing
    try:
        found = measure(traces.users[0], scenario.users[0])
        ideal = transparency(direct, found.frequency_hz).admittance
    except PmwvcError:
        return nothing
    known = found.coherence >= TRUSTED
    slow = known & (found.frequency_hz <= SLOW_HZ)
    stiffness = float((1.0 / found.admittance[slow]).real.mean()) if slow.any() else 0.0
    error = np.abs(np.log10(np.abs(found.admittance) / np.abs(ideal)))
    place = np.digitize(found.frequency_hz, np.geomspace(*BAND_HZ, PARTS + 1)) - 1
    parts = [error[known & (place == number)] for number in range(PARTS)]
    means = [part.mean() for part in parts if len(part)]
    return stiffness, float(np.mean(means)) if len(means) >= PARTS // 2 else math.inf


def _held(probe: Probe) -> tuple[float, float]:
    """Return slope [m/s] and distance at the end [m] of device less avatar while held."""
    traces = simulate_one(_carry(probe, HOLD, SETTLED_S + probe.hold_s))
    slopes, ends = [0.0], [0.0]
    for user in traces.users:
        found = apart(traces, user)
        if found is None or not np.isfinite(found.error).all() or found.time_s[0] > SETTLED_S:
            return math.inf, math.inf
        time_s, distance = found.time_s, found.error[:, 0]
        rows = time_s >= SETTLED_S
        slopes.append(abs(float(np.polyfit(time_s[rows], distance[rows], 1)[0])))
        ends.append(abs(float(distance[time_s >= time_s[-1] - 1.0].mean())))
    return max(slopes), max(ends)


def _completed(probe: Probe) -> float:
    """Return how long the cube of one carry took [s]; infinite where it failed."""
    first = _carry(probe, ONCE, CARRY_S).users[0]
    round_trip_s = mean_s(first.link_up) + mean_s(first.link_down)
    scenario = _carry(probe, ONCE, CARRY_S + ROUND_TRIPS * round_trip_s)
    traces = simulate_one(scenario)
    time_s = placed_s(traces)
    gone = verdict(traces, scenario).instability not in (None, RESTLESS)
    return math.inf if time_s is None or gone else time_s
