# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The duration of a plan on some cores, from what one session took on the machine of the tests."""

import os

from benchmark import networks
from benchmark.study import Plan
from benchmark.walls import GRID
from pmwvc_analysis.maps.workers import cluster
from pmwvc_core.words import count

COMPILING_S = 45.0  # the laws of a method at three kinds of tasks
SESSION_S, INTERPRETED_S = 0.04, 0.7  # with what is measured of it
SWEPT_S = 1.2  # of a minute, compiled
PLAN_S = 0.15  # the fates of all packets on a network


def cores(workers: int | None, dask: str | None) -> int:
    """Return how many sessions run at once."""
    if dask is None:
        return workers or os.cpu_count() or 1
    with cluster(dask) as client:
        return sum(client.ncores().values())


def words(plan: Plan | networks.Plan, at_once: int) -> str:
    """Return what a plan runs and how long that will take."""
    seconds = _study_s(plan) if isinstance(plan, Plan) else _sweep_s(plan)
    minutes = max(1, round(seconds / at_once / 60.0))
    return (
        f"{plan.words}\nabout {count(minutes, 'minute')} on {count(at_once, 'core')}; what is "
        "compiled or finished already is not done again"
    )


def _study_s(plan: Plan) -> float:
    """Return the time of a study on one core."""
    places = len(plan.training) * plan.training_seeds, len(plan.networks) * plan.seeds
    seconds = PLAN_S * len(plan.tasks) * sum(places)
    walls = len(plan.walled) * len(GRID.stiffnesses_n_m) * len(GRID.dampings_n_s_m)
    for name, tried in plan.tried(0).items():
        searched, judged = places[0] * len(tried), len(plan.networks) * plan.seeds_of(name)
        sessions = len(plan.tasks) * (searched + judged) + walls
        compiles = plan.compiles(name)
        seconds += sessions * SESSION_S + COMPILING_S if compiles else sessions * INTERPRETED_S
    return seconds


def _sweep_s(plan: networks.Plan) -> float:
    return SWEPT_S * sum(number for _, number in plan.seeds) * len(plan.networks)
