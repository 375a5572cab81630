# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sessions of the dissertation as scenarios, from plain parameters."""

from collections.abc import Mapping
from typing import Any

from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import Scenario

FRAME_S = 0.008
# As far as the limits of force, slew and speed go: what a figure shows is then the controller's.
UNLIMITED: Mapping[str, Any] = {
    "safety.max_force": 20.0,
    "safety.max_slew": 20000.0,
    "safety.damper_velocity": 10.0,
    "safety.fault_velocity": 20.0,
}
DELAYS = (0, 1, 2, 3)  # of a packet each way, in frames of 8 ms

# App. B, section 4: two users, one cube of 2 kg.
PAIR: Mapping[str, Any] = {
    "master.impedance": 25.0,
    "master.rate_drop": 8,
    "master.hold": "zoh",
    "master.filter.kind": "first_order",
    "master.filter.pole_rad_s": 50.0,
    "device.mass": 0.25,
    "device.damping": 0.0,
    "server.coupling": "one_frame_late",
    "server.contact": "bilateral",
    "server.contact_damping": 10.0,
    "server.object_mass": 2.0,
    "server.period_s": FRAME_S,
}


def pair(**others: Any) -> dict[str, Any]:
    """Return the parameters of two users and a cube; ``others`` with ``__`` for dots."""
    return {**PAIR, **_dotted(others)}


def wall(**others: Any) -> dict[str, Any]:
    """Return the parameters of one user at a wall updated at 50 Hz."""
    base = {
        "master.impedance": 25.0,
        "master.rate_drop": 20,
        "master.hold": "zoh",
        "master.filter.kind": "butterworth",
        "master.filter.pass_hz": 25.0,
        "master.filter.stop_hz": 50.0,
        "device.mass": 0.15,
        "device.damping": 1.0,
        "server.environment": "wall",
        "server.contact": "bilateral",
        "server.coupling": "unwrapped",
        "server.integrator": "trapezoid",
        "server.period_s": 0.02,
    }
    return {**base, **_dotted(others)}


def scenario(
    values: Mapping[str, Any],
    *,
    users: int,
    controller: str = "pmwvc",
    duration_s: float = 1.0,
    task: str = "free",
    operator: Mapping[str, Any] | None = None,
) -> Scenario:
    """Return a scenario with the given parameters by dotted name.

    Parameters
    ----------
    values
        Of the blocks.
    users, controller, duration_s, task
        What happens.
    operator
        Parameters of the hands; by default nobody pushes.
    """
    mapping = {
        "name": "reproduction",
        "duration_s": duration_s,
        "controller": controller,
        "channel": "plain",
        "users": users,
        "operator": dict(operator or {"kind": "none"}),
        "task": {"kind": task},
    }
    return parse_scenario(mapping, overrides=dict(values))


def _dotted(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name.replace("__", "."): value for name, value in values.items()}
