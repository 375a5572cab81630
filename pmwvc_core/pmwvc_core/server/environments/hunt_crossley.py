# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of ``hunt_crossley``: a soft body with nonlinear damping."""

from pmwvc_core.server.black_box.hunt_crossley import HuntCrossley
from pmwvc_core.server.environments.record import Environment

RECORD = Environment(
    name="hunt_crossley",
    words="A soft body that stands still, F = K d^n (1 + c d').",
    linear="wall",
    make=HuntCrossley,
    sloped=True,
    contact_law=False,
)
