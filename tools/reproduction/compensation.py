# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""App. C: energies of a contact whose decoding is a step late, before and after compensation."""

from typing import Any

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.scenario.names import varied
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import SessionTraces
from reproduction.figure import Values
from reproduction.scenarios import scenario
from reproduction.traces import curves, last_mean

AT_REST_M_S = 1e-3
KINDS = ("none", "printed", "corrected", "ledger")


def contact(parameters: Values) -> Values:
    """Return the contact with the compensation drawn, and the lowest balances with every kind."""
    data: Values = {}
    numbers: Values = {}
    for kind in KINDS:
        of = scenario(
            {**parameters["model"], "server.contact": "grip", "server.compensation": kind},
            users=1,
            operator=parameters["operator"],
            duration_s=parameters["duration_s"],
            task="hold",
        )
        traces = simulate_one(of)
        server: Any = traces.server
        after = server.energy_u_s[0] - server.energy_v_s[0]
        before = server.accounts["environment"] + server.accounts["late_decoding"]
        numbers |= {
            f"lowest_before_{kind}_mj": 1e3 * float(before.min()),
            f"lowest_after_{kind}_mj": 1e3 * float(after.min()),
            f"end_after_{kind}_mj": 1e3 * float(after[-1]),
            f"made_by_delay_{kind}_mj": 1e3 * float(server.accounts["late_decoding"][-1]),
            f"apart_from_environment_{kind}": _apart(after, server.accounts["environment"]),
        }
        if kind == parameters["drawn"]:
            full = curves(traces, every_s=0.002)
            wall_mm = -500.0 * of.server.object_size_m
            data = {
                "time_s": full["time_s"],
                "x_m_mm": full["x_1_mm"] - wall_mm,
                "x_s_mm": full["x_s1_mm"] - wall_mm,
                "f_m_n": full["f_1_n"],
                "f_s_n": full["f_s1_n"],
                "step_s": server.time_s,
                "environment_mj": 1e3 * server.accounts["environment"],
                "late_decoding_mj": 1e3 * server.accounts["late_decoding"],
                "before_mj": 1e3 * before,
                "after_mj": 1e3 * after,
            }
            numbers["force_end_n"] = last_mean(full["time_s"], full["f_1_n"])
            numbers["contact_force_end_n"] = last_mean(full["time_s"], full["f_s1_n"])
    return {"data": data, "numbers": numbers | largest_stiffness(parameters["stiffness"])}


def _apart(after: Array, environment: Array) -> float:
    """Return how far the balance is from the environment's own energy, over the largest of it."""
    return float(np.abs(after - environment).max() / max(np.abs(environment).max(), 1e-12))


def largest_stiffness(parameters: Values) -> Values:
    """Return the largest contact stiffness at which a pressed device comes to rest, without and
    with the compensation, for each contact damping, and by what factor that is more.

    All stiffnesses of the grid below it come to rest as well. The device has friction and an
    encoder, as real ones do: its slow limit cycles count as rest below 1 mm/s.
    """
    numbers: Values = {}
    grid = np.arange(*parameters["grid"])
    for damping in parameters["damping"]:
        found = {}
        for kind in ("none", "corrected"):
            base = scenario(
                {
                    **parameters["model"],
                    **parameters["device"],
                    "server.contact_damping": damping,
                    "server.compensation": kind,
                },
                users=1,
                operator={"kind": "constant", "force": parameters["force"]},
                duration_s=parameters["duration_s"],
                task="free",
            )
            found[kind] = 0.0
            for stiffness in grid.tolist():
                run = varied(base, "server.contact_stiffness", stiffness)
                with np.errstate(over="ignore", invalid="ignore"):
                    if not _rests(simulate_one(run)):
                        break
                found[kind] = stiffness
            numbers[f"largest_{kind}_at_{damping:g}"] = found[kind]
        numbers[f"factor_at_{damping:g}"] = found["corrected"] / found["none"]
    return numbers


def _rests(traces: SessionTraces) -> bool:
    velocity = traces.users[0].xd_m
    late = velocity[2 * len(velocity) // 3 :]
    return bool(np.sqrt(np.mean(late**2)) < AT_REST_M_S)
