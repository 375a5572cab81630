# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The description of a session for a page: what stays the same while it runs."""

from collections.abc import Mapping, Sequence
from typing import Any

from pmwvc_analysis.prediction.lag import lag_decides, lag_s
from pmwvc_core.controllers.library import proofs_hold
from pmwvc_core.frame.rows import Presence
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.network.in_flight import FateKind
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import place_of
from pmwvc_core.wave.impedance import MatrixImpedance
from pmwvc_view import controls


def describe(
    scenario: Scenario,
    *,
    mode: str,
    duration_s: float | None,
    values: Mapping[str, Any],
    remote: Sequence[str],
) -> dict[str, Any]:
    """Return the session message without what the server adds.

    Parameters
    ----------
    mode
        live, simulated or recorded.
    duration_s
        Its length; None where it goes on until it is ended [s].
    values
        Of the controls.
    remote
        Users whose handle a page can take.
    """
    server = scenario.server
    return {
        "mode": mode,
        "name": scenario.name,
        "description": scenario.description,
        "controller": scenario.controller,
        "dof": scenario.dof,
        "tick_s": scenario.tick_s,
        "period_s": server.period_s,
        "duration_s": duration_s,
        "object": {
            "environment": server.environment,
            "size_m": server.object_size_m,
            "mass": server.object_mass,
        },
        "users": [
            {
                "name": user.name,
                "side": user.side,
                "remote": user.name in remote,
                "stiffness": user.contact.contact_stiffness,
                "force_limit": user.safety.max_force,
                "workspace_m": user.device.workspace_m,
                "start_m": list(place_of(user, scenario).start),
            }
            for user in scenario.users
        ],
        "controls": controls.to_page(values),
        **controls.choices(),
        "states": {
            "master": [state.name.lower() for state in SafetyState],
            "server": [state.name.lower() for state in Presence],
            "fate": [kind.name.lower() for kind in FateKind],
        },
    }


def within_workspace(
    position: tuple[float, ...] | None, scenario: Scenario, user: str
) -> list[float] | None:
    """Return a page's target within the workspace, one value per axis; None where it is none."""
    if position is None or len(position) != scenario.dof:
        return None
    reach = next(one.device.workspace_m for one in scenario.users if one.name == user)
    return [min(max(value, -reach), reach) for value in position]


def lags(scenario: Scenario, *, live: bool) -> dict[str, float | None]:
    """Return the round trip by the model [s] and the wave impedance [N s/m] of every user, by
    column: F tau/(2b) is the distance of device and avatar at rest. None: not decided by them, or
    an impedance that is a matrix.
    """
    found: dict[str, float | None] = {}
    for user in scenario.users:
        decides = proofs_hold(scenario.controller) and lag_decides(user, scenario)
        found[f"{user.name}.lag"] = lag_s(user, scenario, live=live) if decides else None
        matrix = isinstance(user.impedance, MatrixImpedance)
        found[f"{user.name}.impedance"] = None if matrix else user.master.impedance
    return found
