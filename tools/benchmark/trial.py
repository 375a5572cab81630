# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One session of the benchmark: a method on a network, with the hands and packet fates of a seed.

Two hands grip a 2 kg cube and carry it to and fro. The seed decides the fate of every packet and
varies the hands: stiffness, damping and squeeze by up to 25 %, distance by up to 30 %; all methods
meet the same. :mod:`pmwvc_analysis.compare.settings` tells when a session has failed, or is
restless. One that fails stays in all results.
"""

from dataclasses import dataclass

import numpy as np

from benchmark.carry import (
    apart_max_m,
    energies,
    grip_lost,
    lag_free_error_n,
    squeeze_n,
)
from benchmark.methods import Settings
from pmwvc_analysis.compare.measures import measures
from pmwvc_analysis.compare.settings import cost, failure, path_error_m
from pmwvc_bringup import scenarios as files
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one

SCENARIO = "carry_16ms"
TASK = ("grip_s=0.5", "grip_rise_s=0.5", "move_s=1.5", "move_rise_s=2", "rest_s=0.5")


@dataclass(frozen=True)
class Trial:
    """A session to run; equal trials give equal outcomes."""

    method: str
    settings: Settings
    network: str
    seed: int
    duration_s: float


@dataclass(frozen=True)
class Outcome:
    """The numbers of a session; infinite where it failed.

    Attributes
    ----------
    failure
        What went wrong, in words; empty where nothing did.
    restless
        Whether it keeps oscillating, or that could not be told.
    passive, energy_min_j
        Verdict of all ports, and their lowest balance [J]; None: not known.
    coherency_m, force_error_n, path_error_m
        RMS of device less avatar, of rendered less contact force, of the cube less its target.
    lag_free_error_n, apart_max_m
        Force error with the lag that makes it least; largest distance of device and avatar.
    peak_n, step_n, least_n, dropout_s, buzz_n
        Largest force rendered, its largest change within 1 ms, its least, the time below half of
        the undisturbed one, its RMS above 60 Hz (:mod:`pmwvc_analysis.traces.felt`); zero and all
        the time where the hands do not even hold what can be felt, all of the force where no
        contact lasts long enough to tell.
    squeeze_n
        Mean force between the hands since both first touched the cube.
    grip_lost
        Share of that time in which they did not.
    kept_back, asymmetry
        Energy that stayed between hands and cube, and the difference of the works of the hands,
        per work that they did.
    """

    failure: str
    restless: bool
    passive: bool | None
    energy_min_j: float | None
    coherency_m: float
    force_error_n: float
    path_error_m: float
    lag_free_error_n: float
    apart_max_m: float
    peak_n: float
    step_n: float
    least_n: float
    dropout_s: float
    buzz_n: float
    squeeze_n: float
    grip_lost: float
    kept_back: float
    asymmetry: float

    @property
    def deficit_j(self) -> float:
        """Energy given out beyond what was received, at the worst [J]; infinite: not known."""
        return np.inf if self.energy_min_j is None else max(0.0, -self.energy_min_j)

    @property
    def cost(self) -> float:
        """The cost that the search minimizes (:mod:`pmwvc_analysis.compare.settings`)."""
        errors = self.coherency_m, self.force_error_n, self.path_error_m
        return cost(*errors, restless=self.restless)


def scenario_of(trial: Trial) -> Scenario:
    """Return the scenario of a trial."""
    texts = (*hands(trial.seed), f"link.preset={trial.network}", f"seed={trial.seed}")
    return files.load(
        SCENARIO, settings_texts=(*texts, *trial.settings), duration_s=trial.duration_s
    )


def hands(seed: int) -> Settings:
    """Return the settings of hands and task that a seed stands for."""
    hand = np.random.default_rng((seed, 1)).uniform(-1.0, 1.0, 4)
    return (
        *(f"task.{text}" for text in TASK),
        f"operator.stiffness={120.0 * (1.0 + 0.25 * hand[0]):.6g}",
        f"operator.damping={15.0 * (1.0 + 0.25 * hand[1]):.6g}",
        f"operator.squeeze={2.0 * (1.0 + 0.25 * hand[2]):.6g}",
        f"task.distance_m={0.05 * (1.0 + 0.3 * hand[3]):.6g}",
    )


def run(trial: Trial) -> Outcome:
    """Simulate and measure one session."""
    scenario = scenario_of(trial)
    traces = simulate_one(scenario)
    found = measures(traces, scenario)
    path_m = path_error_m(traces, scenario)
    measured = (
        found["coherency_rms_m"],
        found["force_error_rms_n"],
        path_m,
        lag_free_error_n(traces),
        apart_max_m(traces),
        found["force_peak_n"],
        found["force_step_max_n"],
        found["force_least_n"] or 0.0,
        trial.duration_s if found["dropout_s"] is None else found["dropout_s"],
        found["force_peak_n"] if found["buzz_n"] is None else found["buzz_n"],
        squeeze_n(traces),
        grip_lost(traces),
        *(energies(traces, scenario) or (None, None)),
    )
    errors = [np.inf if error is None else float(error) for error in measured]
    failed = failure(found["instability"], path_m, scenario)
    if failed or not np.isfinite(errors).all():
        failed, errors = failed or "not measured", [np.inf] * len(errors)
    restless = not failed and not found["stable"]
    return Outcome(failed, restless, found["passive"], found["energy_min_j"], *errors)
