# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of ``active_wall``: a wall that a drive moves."""

from pmwvc_core.params import ServerParams
from pmwvc_core.server.black_box.touch import ActiveWall
from pmwvc_core.server.environments.record import Environment


def _drive_hz(params: ServerParams) -> float:
    drive = params.active_wall
    return drive.frequency_hz if drive.amplitude_m > 0.0 else 0.0


def _own_energy(params: ServerParams) -> str:
    return "its environment is driven" if params.active_wall.amplitude_m > 0.0 else ""


RECORD = Environment(
    name="active_wall",
    words="A wall driven along axis 0: it gives out the energy of its drive.",
    linear="wall",
    make=ActiveWall,
    noun="the wall",
    contact_law=False,
    drive_hz=_drive_hz,
    own_energy=_own_energy,
)
