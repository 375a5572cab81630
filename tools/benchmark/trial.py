# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One session of the benchmark: a method on a network, with the hands and packet fates of a seed.

Two hands grip a 2 kg cube and carry it to and fro. The seed decides the fate of every packet and
varies the hands: stiffness, damping and squeeze by up to 25 %, distance by up to 30 %; all methods
meet the same. A session fails if it diverges or a safety layer takes over
(:mod:`pmwvc_analysis.verdicts.stability`), if the users are never coupled, or if the cube is on
the mean further from its target than half the distance it should travel. A session that fails
stays in all results. One that keeps oscillating, or where that cannot be told, is called restless.
"""

from dataclasses import dataclass

import numpy as np

from benchmark.methods import Settings
from pmwvc_analysis.budget.budget import budget
from pmwvc_analysis.budget.result import SERVER
from pmwvc_analysis.compare.measures import measures
from pmwvc_analysis.traces.reductions import COUPLED, rms
from pmwvc_bringup import scenarios as files
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces

SCENARIO = "carry_16ms"
TASK = ("grip_s=0.5", "grip_rise_s=0.5", "move_s=1.5", "move_rise_s=2", "rest_s=0.5")
JND_M, JND_N, PATH_M = 1e-3, 0.2, 5e-3  # anchors of the cost
FAILED_COST, RESTLESS_COST = 100.0, 10.0
RESTLESS = "sustained oscillation"
OF_DEVICE = ("device_kinetic", "device_damping")
OF_SERVER = ("contact_damping", "contact_stored", "object_kinetic", "object_damping")


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
    peak_n
        Largest force rendered.
    grip_lost
        Share of the time since both hands first touched the cube in which they did not.
    kept_back
        Energy that stayed between hands and cube, per work that the hands did.
    """

    failure: str
    restless: bool
    passive: bool | None
    energy_min_j: float | None
    coherency_m: float
    force_error_n: float
    path_error_m: float
    peak_n: float
    grip_lost: float
    kept_back: float

    @property
    def cost(self) -> float:
        """What the search makes small: the three errors in units of what is just noticed
        (position 1 mm, force a tenth of the squeeze) and of a tenth of the way (5 mm), and 10
        where restless.
        """
        errors = (
            self.coherency_m / JND_M, self.force_error_n / JND_N, self.path_error_m / PATH_M,
        )  # fmt: skip
        return min(sum(errors) + RESTLESS_COST * self.restless, FAILED_COST)


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
        found["force_peak_n"],
        grip_lost(traces),
        kept_back(traces, scenario),
    )
    errors = [np.inf if error is None else float(error) for error in measured]
    failure = _failure(found["instability"], path_m, scenario)
    if failure or not np.isfinite(errors).all():
        failure, errors = failure or "not measured", [np.inf] * len(errors)
    restless = not failure and not found["stable"]
    return Outcome(failure, restless, found["passive"], found["energy_min_j"], *errors)


def path_error_m(traces: SessionTraces, scenario: Scenario) -> float | None:
    """Return the RMS distance of the cube from its target since that began to move [m]; None where
    the users were not all coupled before.
    """
    server = traces.server
    if server is None:
        return None
    together = np.flatnonzero(np.all([state == COUPLED for state in server.state], axis=0))
    if not len(together):
        return None
    moving = server.time_s >= server.time_s[together[0]] + scenario.task.move_s
    apart = (server.x_o - server.target)[moving]
    return rms(apart) if len(apart) else None


def grip_lost(traces: SessionTraces) -> float | None:
    """Return the share of steps in which not all hands touched the cube, since they first did;
    None where they never did.
    """
    if traces.server is None:
        return None
    touching = np.all(traces.server.contact, axis=0)
    held = np.flatnonzero(touching)
    return float(1.0 - touching[held[0] :].mean()) if len(held) else None


def kept_back(traces: SessionTraces, scenario: Scenario) -> float | None:
    """Return the energy that neither devices nor contacts nor cube had at the end, per work of the
    hands, None where it is not known.
    """
    found = budget(traces, scenario)
    if found is None:
        return None
    work = sum(float(np.diff(sums).clip(0.0).sum()) for sums in found.hands.values())
    parts = [
        float(sums[-1])
        for owner, each in found.parts.items()
        for part, sums in each.items()
        if part not in (OF_SERVER if owner == SERVER else OF_DEVICE)
    ]
    return sum(parts) / work if work > 0.0 else None


def _failure(instability: str | None, path_m: float | None, scenario: Scenario) -> str:
    if instability not in (None, RESTLESS):
        return instability
    if path_m is None:
        return "never coupled"
    return "" if path_m < 0.5 * scenario.task.distance_m else "task not done"
