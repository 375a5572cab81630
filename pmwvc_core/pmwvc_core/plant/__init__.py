# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The person's side in simulation: device, hand, recorded operators, task."""

from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.plant.operators import OPERATORS, Operator, make_operator
from pmwvc_core.plant.playback import load_recording
from pmwvc_core.plant.task import Task

__all__ = [
    "OPERATORS",
    "Operator",
    "SimulatedDevice",
    "Task",
    "load_recording",
    "make_operator",
]
