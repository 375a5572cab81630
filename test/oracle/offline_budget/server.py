# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server: late decoding, contacts, object, and what an unknown environment stores."""

import numpy as np
from oracle.offline_budget.motion import WEIGHTS, speeds
from oracle.offline_budget.sums import Clock, Sums, running

from pmwvc_core.controllers.library import has_waves
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces

MOVED_BY_NEW_FORCE = ("implicit", "one_frame_late")  # the others: by the force of the step before


def server_account(clock: Clock, server: ServerTraces, scenario: Scenario) -> Sums:
    """Return what the server took in and where it is [J].

    ``into_server`` at all wave ports; ``late_decoding``, ``contact_damping``, ``contact_stored``,
    ``object_kinetic``, ``object_damping``; ``integration``, which the steps of a sampled coupling
    leave over; ``residual``. The implicit coupling leaves nothing over; there it is the residual.
    An unknown environment has parts of its own.
    """
    into = sum(
        (
            running(u) - running(v)
            for u, v in zip(server.energy_u_s, server.energy_v_s, strict=True)
        ),
        start=np.zeros(len(server.time_s)),
    )
    power = sum(
        np.nan_to_num(np.sum(f * xd, axis=-1))
        for f, xd in zip(server.f_s, server.xd_s, strict=True)
    )
    work = np.cumsum(power) * server.period_s
    waves = has_waves(scenario.controller)
    if waves and scenario.server.coupling == "unknown":
        found = _of_unknown(server, into, work)
    else:
        found = _of_known(server, scenario, into, work, waves=waves)
    return {name: sums[clock.steps] for name, sums in {"into_server": into, **found}.items()}


def _of_known(
    server: ServerTraces, scenario: Scenario, into: Array, work: Array, *, waves: bool
) -> Sums:
    coupling = scenario.server.coupling
    decoding = into - work if waves and coupling == "one_step_delay" else np.zeros_like(into)
    damping, missing = _object_heat(server, scenario)
    contact = server.dissipated - damping - missing
    left = into - decoding - server.kinetic - server.potential - server.dissipated
    exact = waves and coupling == "implicit"
    return {
        "late_decoding": decoding,
        "integration": 0.0 * left if exact else left,
        "contact_damping": contact,
        "contact_stored": server.potential,
        "object_kinetic": server.kinetic,
        "object_damping": damping,
        "residual": left + missing if exact else missing,
    }


def _of_unknown(server: ServerTraces, into: Array, work: Array) -> Sums:
    """Return the parts of a port that knows nothing of its environment: what it booked, and the
    work of the forces as recorded. Contained users' forces are those of a matched damper.
    """
    accounts = server.accounts
    return {
        "late_decoding": accounts["late_decoding"],
        "withheld": accounts["withheld"],
        "contained": accounts["contained"],
        "environment_stored": server.potential,
        "environment_heat": work - accounts["contained"] - server.potential,
        "residual": into - work - accounts["late_decoding"] - accounts["withheld"],
    }


def _object_heat(server: ServerTraces, scenario: Scenario) -> tuple[Array, Array]:
    """Return the heat of the object's damper [J], and what the forces' work on it leaves over."""
    params = scenario.server
    if params.environment != "cube":
        return np.zeros(len(server.time_s)), np.zeros(len(server.time_s))
    force = sum((np.nan_to_num(f) for f in server.f_s), start=np.zeros_like(server.x_o))
    moved = np.diff(server.x_o, axis=0, prepend=server.x_o[:1])
    before = np.concatenate([0.0 * server.xd_o[:1], server.xd_o[:-1]])
    coupling = params.coupling if has_waves(scenario.controller) else None
    if coupling not in MOVED_BY_NEW_FORCE:
        force = np.concatenate([0.0 * force[:1], force[:-1]])
    if coupling == "implicit":
        heat = params.object_damping * np.sum(moved**2, axis=-1) / server.period_s
    else:
        nodes = speeds(params.object_mass, params.object_damping, server.period_s, before, force)
        square = sum(0.5 * w * np.sum(v**2, axis=-1) for w, v in zip(WEIGHTS, nodes, strict=True))
        heat = params.object_damping * server.period_s * square
    kinetic = np.diff(server.kinetic, prepend=0.0)
    missing = np.sum(force * moved, axis=-1) - kinetic - heat
    return np.cumsum(heat), np.cumsum(missing)
