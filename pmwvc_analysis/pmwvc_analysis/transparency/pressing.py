# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A steady press: one user with 1 N, the others so that the object is in balance.

Ends of different impedance are a transformer: a force f of the device is n f at the object,
n = sqrt(B_server) sqrt(B_master)^-1, with numbers n^2 = b_server/b_master.
"""

import numpy as np

from pmwvc_analysis.models.linear import axes_of
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.law.wave.wave import free_velocity, rooted
from pmwvc_core.made.waves import through
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario


def pressing(scenario: Scenario, user: int, axis: int = 0) -> Array:
    """Return the forces ``(users, dof)`` [N] that keep the object in balance while one user
    presses with 1 N.
    """
    axes = axes_of(scenario)
    pushed = np.eye(axes)[axis if axes > 1 else 0]
    forces = np.zeros((len(scenario.users), axes))
    forces[user] = pushed
    if not scenario.environment.movable:
        return forces
    waves, first = has_waves(scenario.controller), scenario.users[user]
    opposite = [i for i, other in enumerate(scenario.users) if other.side != first.side]
    for index in opposite:
        force = pushed
        if waves:
            other = scenario.users[index]
            force = through(free_velocity, first.impedance, 0.25 * force)
            force = through(rooted, first.server_impedance, force)
            force = through(free_velocity, other.server_impedance, force)
            force = through(rooted, other.impedance, force)
        forces[index] = -force / len(opposite)
    return forces
