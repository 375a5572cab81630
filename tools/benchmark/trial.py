# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One session of the benchmark: a method at a task on a network, with the hands and packet fates
of a seed. :mod:`benchmark.cost` tells when a session has failed, or is restless.
One that fails stays in all results, with infinite numbers.
"""

import dataclasses
import math
from dataclasses import dataclass

from benchmark import feel
from benchmark.carry import absorbed, completion_s, grip_lost
from benchmark.cost import FAILED_COST, cost, failure, path_error_m
from benchmark.fast import simulated
from benchmark.methods import Settings
from benchmark.tasks import TASKS, scenario_of
from pmwvc_analysis.compare.measures import coherency_m, force_error_n, least_balance
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

BUZZ_N = 0.05  # of cost 1


@dataclass(frozen=True)
class Trial:
    """A session to run; equal trials give equal outcomes."""

    method: str
    settings: Settings
    task: str
    network: str
    seed: int
    duration_s: float

    @property
    def scenario(self) -> Scenario:
        """The scenario of the session."""
        return scenario_of(self.task, self.settings, self.network, self.seed, self.duration_s)


@dataclass(frozen=True)
class Cost:
    """What the search looks at (:mod:`benchmark.cost`), and the buzz."""

    cost: float


@dataclass(frozen=True)
class Outcome:
    """The numbers of a session; infinite where it failed, None where the task has none.

    Attributes
    ----------
    failure, restless
        What went wrong, in words, empty where nothing did; whether it keeps oscillating, or that
        could not be told (of a recorded person: it is known that it does).
    passive, energy_min_j
        Verdict of all ports, and their lowest balance [J]; None: not known.
    coherency_m, force_error_n, lag_free_error_n
        RMS of device less avatar, of rendered less contact force, and of that with the lag that
        makes it least.
    contact_n
        RMS of the force at the contact.
    peak_n, step_n, buzz_n, held_share, dropout_s
        Largest force rendered, its largest change within 1 ms, its RMS above 60 Hz, the share of
        that at the rates of packets; how long it was less than half of what it is while a hand
        holds or presses.
    path_error_m, completion_s, grip_lost, absorbed
        Of the cube: RMS distance from its target, time of a move until it is within 5 mm of its
        end; share of the time in which not both hands touched it; energy that stayed between hands
        and cube, per work of the hands.
    stiffness_n_m
        Felt at the wall.
    mass_kg, damping_n_s_m, lag_s
        Of the link alone in free motion, and the time by which the avatar follows the device.
    """

    failure: str
    restless: bool
    passive: bool | None
    energy_min_j: float | None
    coherency_m: float | None
    force_error_n: float | None
    lag_free_error_n: float | None
    contact_n: float | None
    peak_n: float | None
    step_n: float | None
    buzz_n: float | None
    held_share: float | None
    dropout_s: float | None = None
    path_error_m: float | None = None
    completion_s: float | None = None
    grip_lost: float | None = None
    absorbed: float | None = None
    stiffness_n_m: float | None = None
    mass_kg: float | None = None
    damping_n_s_m: float | None = None
    lag_s: float | None = None

    @property
    def deficit_j(self) -> float:
        """Energy given out beyond what was received, at the worst [J]; infinite: not known."""
        return math.inf if self.energy_min_j is None else max(0.0, -self.energy_min_j)


def costed(trial: Trial, *, compiled: bool) -> Cost:
    """Run a session of the search; nothing is measured that its cost does not need."""
    scenario = trial.scenario
    traces = simulated(scenario, compiled=compiled)
    failed, restless, path_m = _judged(trial, traces, scenario)
    if failed:
        return Cost(FAILED_COST)
    errors = coherency_m(traces), force_error_n(traces), path_m
    buzz_n = feel.worst(traces, scenario).buzz_n or 0.0
    return Cost(min(cost(*errors, restless=restless) + buzz_n / BUZZ_N, FAILED_COST))


def run(trial: Trial, *, compiled: bool = False) -> Outcome:
    """Run and measure one session."""
    scenario = trial.scenario
    traces = simulated(scenario, compiled=compiled)
    failed, restless, path_m = _judged(trial, traces, scenario)
    balance, felt = least_balance(traces, scenario), feel.worst(traces, scenario)
    found = Outcome(
        failed,
        restless,
        balance["passive"],
        balance["energy_min_j"],
        coherency_m=coherency_m(traces),
        force_error_n=force_error_n(traces),
        lag_free_error_n=feel.lag_free_error_n(traces),
        contact_n=feel.contact_n(traces),
        peak_n=feel.peak_n(traces),
        step_n=felt.step_n,
        buzz_n=felt.buzz_n,
        held_share=feel.held_share(traces, scenario),
        **_of_task(trial.task, traces, scenario, path_m, felt.dropout_s),
    )
    numbers = {
        name: value
        for name, value in dataclasses.asdict(found).items()
        if name not in ("failure", "restless", "passive", "energy_min_j") and value is not None
    }
    if failed or not all(map(math.isfinite, (found.coherency_m or 0.0, found.peak_n or 0.0))):
        numbers = dict.fromkeys(numbers, math.inf) | dict.fromkeys(_larger(numbers), 0.0)
        failed = failed or "not measured"
    return dataclasses.replace(found, failure=failed, **numbers)


def _larger(numbers: dict[str, float]) -> set[str]:
    """Return the numbers of which the larger is the better: none where it failed."""
    return {"stiffness_n_m"} & set(numbers)


def _judged(
    trial: Trial, traces: SessionTraces, scenario: Scenario
) -> tuple[str, bool, float | None]:
    """Return how a session failed, whether it is restless, and the error of the cube's path."""
    found, path_m = verdict(traces, scenario), path_error_m(traces, scenario)
    failed = failure(found.instability, path_m, scenario)
    restless = found.stable is False if trial.task == "tapping" else not found.stable
    return failed, restless and not failed, path_m


def _of_task(
    task: str, traces: SessionTraces, scenario: Scenario, path_m: float | None, dropout_s: float
) -> dict[str, float | None]:
    """Return the numbers that a task alone has."""
    if task == "carry":
        return {
            "path_error_m": math.inf if path_m is None else path_m,
            "completion_s": completion_s(traces, scenario),
            "grip_lost": grip_lost(traces),
            "absorbed": absorbed(traces, scenario),
            "dropout_s": dropout_s,
        }
    if task == "wall":
        return dict(
            zip(("stiffness_n_m", "dropout_s"), feel.pressed(traces, scenario), strict=True)
        )
    if task == "free":
        mass_kg, damping_n_s_m = feel.moved(traces)
        lag_s = feel.lag_s(traces)
        return {"mass_kg": mass_kg, "damping_n_s_m": damping_n_s_m, "lag_s": lag_s}
    return {}


def usual(name: str, settings: Settings, task: str, network: str, seed: int) -> Trial:
    """Return a trial of the usual duration of its task."""
    return Trial(name, settings, task, network, seed, TASKS[task].duration_s)
