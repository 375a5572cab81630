# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions that measure what a method renders on a network, the same for all methods.

======================  ===========================================================================
``stiffness_max_n_m``   largest stiffness of a wall (contact damping 10 N s/m) on which one hand
                        rests without oscillation or help of the safety limits, and keeps half of
                        its largest force (means of a second): one line of the Z-width, by
                        bisection to 10 %; 0: not even the softest
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
======================  ===========================================================================

What could not be measured has failed: no stiffness (0), all others infinite.
"""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from benchmark.methods import Settings
from benchmark.trial import Trial, hands, scenario_of
from pmwvc_analysis.compare.probes import free_space
from pmwvc_analysis.traces.reductions import position_error
from pmwvc_analysis.transparency.measured import TRUSTED, measure
from pmwvc_analysis.transparency.transparency import ideal_of, transparency
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_bringup import scenarios as files
from pmwvc_core.errors import PmwvcError
from pmwvc_core.network.effects import mean_s
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces

SOFTEST_N_M, STIFFEST_N_M, RATIO = 10.0, 20000.0, 1.1
WALL_S, ROUND_TRIPS = 6.0, 8.0  # duration of a session at the wall, and for each round trip more
CHIRP = (
    *("task.kind=free", "operator.kind=chirp", "operator.force=1", "operator.frequency_hz=0.2"),
    *("operator.frequency_end_hz=20", "operator.sweep_s=20", "server.contact=bilateral"),
    *("server.gap_m=0", "server.contact_stiffness=500"),
)
CHIRP_S = 24.0
BAND_HZ, PARTS = (0.2, 20.0), 20
SLOW_HZ = 0.5
KEEPS = 0.5
SETTLED_S = 5.0  # from when on a hold counts
HOLD = ("task.kind=hold",)


@dataclass(frozen=True)
class Probe:
    """What is measured: a method on a network."""

    method: str
    settings: Settings
    network: str
    seed: int
    hold_s: float


@dataclass(frozen=True)
class Rendered:
    """What was rendered; see the module."""

    stiffness_max_n_m: float
    stiffness_n_m: float
    mass_kg: float
    damping_n_s_m: float
    transparency: float
    drift_m_s: float
    held_apart_m: float


def rendered(probe: Probe) -> Rendered:
    """Run all sessions of a probe."""
    carry = scenario_of(Trial(probe.method, probe.settings, probe.network, probe.seed, 1.0))
    free = free_space(carry)
    direct = dataclasses.replace(probe, settings=("controller=direct",))
    stiffness, error = _wall_rendered(
        _wall(probe, CHIRP, CHIRP_S), ideal_of(_wall(direct, CHIRP, CHIRP_S))
    )
    drift_m_s, held_apart_m = _held(probe)
    return Rendered(
        stiffness_max_n_m=_stiffness_max(probe),
        stiffness_n_m=stiffness,
        mass_kg=free.mass_kg if free else math.inf,
        damping_n_s_m=free.damping_n_s_m if free else math.inf,
        transparency=error,
        drift_m_s=drift_m_s,
        held_apart_m=held_apart_m,
    )


def _wall(probe: Probe, settings: Settings, duration_s: float) -> Scenario:
    texts = (f"link.preset={probe.network}", f"seed={probe.seed}", *probe.settings)
    return files.load("wall", settings_texts=(*texts, *settings), duration_s=duration_s)


def _stiffness_max(probe: Probe) -> float:
    """Return the stiffness at which a stable range that begins at the softest ends [N/m]."""
    own = tuple(text for text in hands(probe.seed) if text.startswith("operator."))
    first = _wall(probe, own, WALL_S).users[0]
    round_trip_s = mean_s(first.link_up) + mean_s(first.link_down)
    duration_s = WALL_S + ROUND_TRIPS * round_trip_s

    def rests(stiffness: float) -> bool:
        settings = (*own, f"server.contact_stiffness={stiffness:.6g}")
        scenario = _wall(probe, settings, duration_s)
        traces = simulate_one(scenario)
        return _keeps_pressing(traces) and verdict(traces, scenario).stable is True

    if not rests(SOFTEST_N_M):
        return 0.0
    if rests(STIFFEST_N_M):
        return STIFFEST_N_M
    low, high = SOFTEST_N_M, STIFFEST_N_M
    while high > RATIO * low:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if rests(middle) else (low, middle)
    return low


def _keeps_pressing(traces: SessionTraces) -> bool:
    """Tell whether the force at the wall in the last second is half of its largest, or more."""
    server = traces.server
    if server is None:
        return False
    second = round(1.0 / server.period_s)
    force = np.abs(server.f_s[0][:, 0])
    means = force[: len(force) // second * second].reshape(-1, second).mean(axis=1)
    return bool(means[-1] > 0.0 and means[-1] >= KEEPS * means.max())


def _wall_rendered(scenario: Scenario, direct: Scenario) -> tuple[float, float]:
    """Return stiffness [N/m] and error of the impedance [decades] of a wall; ``direct``: what it
    is compared with.
    """
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
    settings = (*probe.settings, *HOLD)
    trial = Trial(probe.method, settings, probe.network, probe.seed, SETTLED_S + probe.hold_s)
    traces = simulate_one(scenario_of(trial))
    server, slopes, ends = traces.server, [0.0], [0.0]
    for index, user in enumerate(traces.users):
        apart = position_error(user, server, index) if server is not None else None
        if apart is None or not np.isfinite(apart[1]).all() or apart[0][0] > SETTLED_S:
            return math.inf, math.inf
        time_s, distance = apart[0], apart[1][:, 0]
        rows = time_s >= SETTLED_S
        slopes.append(abs(float(np.polyfit(time_s[rows], distance[rows], 1)[0])))
        ends.append(abs(float(distance[time_s >= time_s[-1] - 1.0].mean())))
    return max(slopes), max(ends)
