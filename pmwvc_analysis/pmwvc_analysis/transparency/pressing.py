# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A steady press: one user with 1 N, the others so that the object is in balance; what is said
of it.
"""

import math
from typing import Any

import numpy as np

from pmwvc_analysis.models.linear import axes_of
from pmwvc_analysis.models.linearize import Linear
from pmwvc_analysis.transparency.frequency import limit_at_rest, low_frequencies, response
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.numeric import Array, root
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.impedance import transformation


def pressing(scenario: Scenario, user: int, axis: int = 0) -> Array:
    """Return the forces that keep the object in balance while one user presses with 1 N.

    Ends of different impedance are a transformer: a force f of the device is n f at the object,
    n = sqrt(B_server) sqrt(B_master)^-1, with numbers n^2 = b_server/b_master.

    Returns
    -------
    ndarray
        Of every user, along each axis of the model ``(users, dof)`` [N].
    """
    axes = axes_of(scenario)
    pushed = np.eye(axes)[axis if axes > 1 else 0]
    forces = np.zeros((len(scenario.users), axes))
    forces[user] = pushed
    if not scenario.environment.movable:
        return forces
    waves, side = has_waves(scenario.controller), scenario.users[user].side
    opposite = [index for index, other in enumerate(scenario.users) if other.side != side]
    for index in opposite:
        force = pushed
        if waves:
            own, server = _roots(scenario.users[index])
            force = np.asarray(own * (at_object(scenario.users[user], pushed) / server))
        forces[index] = -force / len(opposite)
    return forces


def at_object(user: User, force: Array) -> Array:
    """Return a steady force of a user's device at the object [N]."""
    master, server = _roots(user)
    return np.asarray(server * (force / master))


def _roots(user: User) -> tuple[Any, Any]:
    """Return the square roots of the impedances of a user's ends: numbers or matrices."""
    ends: tuple[Any, Any] = user.impedance, user.server_impedance
    return root(ends[0]), root(ends[1])


def scale_notes(scenario: Scenario, user: int) -> list[str]:
    """Return a note where the ends of a user's link are a transformer."""
    if not has_waves(scenario.controller):
        return []
    own = scenario.users[user]
    if (axes := axes_of(scenario)) > 1:
        if np.allclose([at_object(own, force) for force in np.eye(axes)], np.eye(axes)):
            return []
        return [
            "The ends have different impedance matrices: they scale and turn motion and force; "
            "the ideal coupling does not."
        ]
    scale = math.sqrt(transformation(own.impedance, own.server_impedance))
    if math.isclose(scale, 1.0):
        return []
    return [
        f"The ends have different impedance: the device moves {scale:.3g} times as far as its "
        f"avatar, with 1/{scale:.3g} of its force; the ideal coupling does not."
    ]


def across_notes(
    model: Linear, user: int, axis: int, forces: Array, peak_hz: float | None
) -> list[str]:
    """Return a note on the motion at rest across the axis, where the axes are coupled."""
    dof = model.loop.dof
    if dof == 1:
        return []
    others = [other for other in range(dof) if other != axis]
    low = low_frequencies(peak_hz)
    moved = [
        limit_at_rest(response(model, low, user=user, forces=forces, axis=other).real)
        for other in others
    ]
    each = ", ".join(f"{1e3 * x:.3g} (axis {o + 1})" for o, x in zip(others, moved, strict=True))
    return [
        f"Along axis {axis + 1} of {dof}, the other axes free. The impedance matrix couples "
        f"them: at rest 1 N moves the device of {model.users[user]} across by {each} mm."
    ]


def how(scenario: Scenario, user: int, forces: Array, *, balanced: bool) -> str:
    """Return what is pressed against what."""
    name = scenario.users[user].name
    if not scenario.environment.movable:
        return f"{name} presses against the wall."
    others = [
        other.name
        for index, (other, force) in enumerate(zip(scenario.users, forces, strict=True))
        if index != user and np.any(force)
    ]
    if not others:
        return f"{name} pushes the object alone."
    against = f"{name} presses against {' and '.join(others)}"
    if not balanced:
        return f"{against}; their forces do not balance at the object."
    return f"{against}, so the object stays at rest."
