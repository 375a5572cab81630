# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The device of a user in virtual time and the hand on it, where a session begins."""

import numpy as np

from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.plant.forces import Operator, Setting
from pmwvc_core.plant.operators import make_operator
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import Conditions


def device_and_hand(
    scenario: Scenario, index: int, runs: int, conditions: Conditions
) -> tuple[SimulatedDevice, Operator]:
    """Return device and hand of the user with a number (from 0), in a batch of ``runs``."""
    user, dof, tick_s = scenario.users[index], scenario.dof, scenario.tick_s
    half = scenario.server.object_size_m / 2
    start = user.side * (half + user.contact.gap_m)
    device = SimulatedDevice(user.device, tick_s=tick_s, dof=dof)
    # In a batch every run has a place of its own from the beginning.
    device.place(start + np.zeros((runs, 1)) if runs > 1 else start)
    if hand := conditions.hands.get(user.name):
        return device, hand()
    at = Setting(user.side, half, start, tick_s, dof)
    return device, make_operator(user.operator, scenario.task, at)
