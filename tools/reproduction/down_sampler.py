# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy of the rate drop over the cut-off of the filter in front of it (App. A Fig. 8).

A session is simulated once per filter; E_1 is the energy after the filter, E_2 that of the
packets. Their difference is what the down-sampler keeps, and it may be below zero.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.params import FilterParams
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate
from pmwvc_core.traces import SessionTraces


class CutOffEnergy(TypedDict):
    """Energy kept by the down-sampler, one entry per filter; ``finite`` False: it diverged."""

    minimum_j: Array
    final_j: Array
    finite: list[bool]
    time_s: list[Array]
    left_j: list[Array]


def printed_scenario(**overrides: Any) -> Scenario:
    """Return the wall of App. A Fig. 8: a chirp of 1 N from 0 to 10 Hz in 30 s, M = 20.

    The text gives K, B and T_VE; b = 80 N s/m is that of Figs. 6 and 7, the device that of Fig. 4,
    the coupling the one whose loop is solved. ``overrides`` by dotted name.
    """
    mapping: Mapping[str, Any] = {
        "name": "down_sampler",
        "duration_s": 31.0,
        "controller": "pmwvc",
        "channel": "plain",
        "users": 1,
        "master": {"impedance": 80.0, "rate_drop": 20, "hold": "zoh"},
        "device": {"mass": 0.15, "damping": 1.0},
        "operator": {
            "kind": "chirp",
            "force": 1.0,
            "frequency_hz": 0.0,
            "frequency_end_hz": 10.0,
            "sweep_s": 30.0,
        },
        "server": {
            "environment": "wall",
            "contact": "bilateral",
            "coupling": "unwrapped",
            "integrator": "trapezoid",
            "period_s": 0.02,
            "contact_stiffness": 3500.0,
            "contact_damping": 25.0,
        },
        "task": {"kind": "free"},
    }
    return parse_scenario(mapping, overrides=overrides)


def energy_over_cut_off(scenario: Scenario, filters: Sequence[FilterParams]) -> CutOffEnergy:
    """Return what the first user's down-sampler keeps of the energy, lowest and last, per filter.

    Parameters
    ----------
    scenario
        The session; its filter is replaced.
    filters
        What stands before the rate drop, one session each.
    """
    found = simulate([with_filter(scenario, one) for one in filters])
    accounts = [_account(traces, scenario) for traces in found]
    return {
        "minimum_j": np.array([left.min(initial=0.0) for _, left in accounts]),
        "final_j": np.array([left[-1] for _, left in accounts]),
        "finite": [bool(np.isfinite(left).all()) for _, left in accounts],
        "time_s": [time_s for time_s, _ in accounts],
        "left_j": [left for _, left in accounts],
    }


def with_filter(scenario: Scenario, params: FilterParams) -> Scenario:
    """Return the scenario with another anti-aliasing filter for every user."""
    users = tuple(
        dataclasses.replace(user, master=dataclasses.replace(user.master, filter=params))
        for user in scenario.users
    )
    return dataclasses.replace(scenario, users=users)


def _account(traces: SessionTraces, scenario: Scenario) -> tuple[Array, Array]:
    """Return time and energy after the filter less that of the packets, at each frame start.

    A packet counts with its whole frame when it is sent; a tick counts once it has run.
    """
    user = traces.users[0]
    master = scenario.users[0].master
    sent = traces.packets[f"/{user.name}/wave_up"]
    before = np.concatenate([[0.0], np.cumsum(0.5 * np.sum(user.u_m_lp**2, axis=-1))])
    ticks = np.arange(len(sent.seq)) * master.rate_drop
    packets = np.cumsum(0.5 * np.sum(sent.wave**2, axis=-1)) * master.frame_s
    left: Array = before[ticks] * master.tick_s - packets
    return np.asarray(ticks * master.tick_s, dtype=float), left
