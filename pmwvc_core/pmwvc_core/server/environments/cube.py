# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of ``cube``: the shared object, carried by whoever pushes it."""

from pmwvc_core.params import ServerParams
from pmwvc_core.server.black_box.touch import FreeCube
from pmwvc_core.server.cube import Body, Cube
from pmwvc_core.server.environments.record import Environment


def _body(params: ServerParams) -> Body:
    return Cube(params.object_mass, params.object_damping, period=params.period_s)


RECORD = Environment(
    name="cube",
    words="The shared object, which moves freely.",
    linear="cube",
    make=FreeCube,
    body=_body,
    noun="the cube",
    movable=True,
)
