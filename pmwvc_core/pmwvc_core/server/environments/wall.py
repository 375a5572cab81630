# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The records of ``wall`` and ``wall_with_slope``: contacts with a body that never moves."""

from pmwvc_core.server.black_box.touch import SlopedWall, TouchedWall
from pmwvc_core.server.environments.record import Environment
from pmwvc_core.server.fixed_body import FixedBody

RECORD = Environment(
    name="wall",
    words="A wall that does not move.",
    linear="wall",
    make=TouchedWall,
    body=lambda params: FixedBody(),
    noun="the wall",
    with_slope="wall_with_slope",
    spring=True,
)
WITH_SLOPE = Environment(
    name="wall_with_slope",
    words="A wall that reports the slope of its force.",
    linear="wall_with_slope",
    make=SlopedWall,
    noun="the wall",
    sloped=True,
    spring=True,
)
