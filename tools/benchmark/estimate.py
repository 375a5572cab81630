# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The duration of a plan on some cores, from sessions timed on this machine beforehand."""

import os
import time
from collections.abc import Callable
from typing import Any

from benchmark import networks
from benchmark.methods import METHODS
from benchmark.probe import Probe, rendered
from benchmark.study import HELD_OUT_SEED, Plan
from benchmark.trial import Trial, run
from pmwvc_analysis.maps.workers import dask_cores
from pmwvc_core.words import count

SWEPT_S = 4.0  # duration of the sessions timed for a sweep of networks


def cores(workers: int | None, dask: str | None) -> int:
    """Return how many sessions run at once."""
    return dask_cores(dask) if dask is not None else workers or os.cpu_count() or 1


def words(plan: Plan | networks.Plan, at_once: int) -> str:
    """Return what a plan runs and how long that will take, after timing some of it."""
    if isinstance(plan, Plan):
        what, seconds = plan.words, _study_s(plan)
    else:
        what, seconds = plan.words, _sweep_s(plan)
    minutes = max(1, round(seconds / at_once / 60.0))
    return (
        f"{what}\nestimated: {count(minutes, 'minute')} on {count(at_once, 'core')} of this kind "
        "(some of its sessions timed just now, one at a time); what is finished already is not "
        "run again"
    )


def _study_s(plan: Plan) -> float:
    """Return the time of a study on one core: a session of each method and one probe timed, the
    probes of the others in proportion to their sessions.
    """
    network, seed = plan.training[0], HELD_OUT_SEED
    settings = {name: METHODS[name].settings for name in plan.methods}
    session_s = {
        name: _took(run, Trial(name, settings[name], network, seed, plan.duration_s))
        for name in plan.methods
    }
    first = plan.methods[0]
    probe_s = 0.0
    if plan.probed:
        probe_s = _took(rendered, Probe(first, settings[first], network, seed, plan.hold_s))
    total_s = sum(session_s.values())
    return total_s * (plan.sessions + plan.probed * probe_s / session_s[first])


def _sweep_s(plan: networks.Plan) -> float:
    """Return the time of a sweep on one core; its batches of equal fates take less."""
    network = plan.networks[-1]
    return sum(
        _took(networks.found_in, networks.Group(channel, network, (0,), SWEPT_S))
        * (seeds * len(plan.networks) * plan.duration_s / SWEPT_S)
        for channel, seeds in plan.seeds
    )


def _took(work: Callable[[Any], Any], item: object) -> float:
    began = time.perf_counter()
    work(item)
    return time.perf_counter() - began
