# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The conditions of an analysis of transparency, in sentences."""

import math

import numpy as np

from pmwvc_analysis.models.linear import axes_of
from pmwvc_analysis.models.multirate import MultirateModel
from pmwvc_analysis.transparency.frequency import limit_at_rest, low_frequencies, response
from pmwvc_analysis.transparency.pressing import at_object
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.wave.impedance import transformation


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
    model: MultirateModel, user: int, axis: int, forces: Array, peak_hz: float | None
) -> list[str]:
    """Return a note on the motion at rest across the axis, where the axes are coupled."""
    if model.dof == 1:
        return []
    others = [other for other in range(model.dof) if other != axis]
    low = low_frequencies(peak_hz)
    moved = [
        limit_at_rest(response(model, low, user=user, forces=forces, axis=other).real)
        for other in others
    ]
    each = ", ".join(f"{1e3 * x:.3g} (axis {o + 1})" for o, x in zip(others, moved, strict=True))
    return [
        f"Along axis {axis + 1} of {model.dof}, the other axes free. The impedance matrix couples "
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
