# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments by name: the shared cube, and a wall that does not move.

A wall is the cube nailed down: the same faces and contact laws, no motion. Another environment is
a class with the methods of ``cube.Body`` and a line in ``ENVIRONMENTS``.
"""

from collections.abc import Callable, Mapping

from pmwvc_core.numeric import Value
from pmwvc_core.params import ServerParams
from pmwvc_core.server.cube import Body, Cube


class Wall:
    """An object that never moves: whatever the force, velocity zero, no energy taken."""

    def __init__(self) -> None:
        self.x: Value = 0.0
        self.xd: Value = 0.0

    @property
    def kinetic(self) -> Value:
        """Zero."""
        return 0.0

    def push(self, force: Value) -> tuple[Value, Value]:
        """Stay."""
        return 0.0 * force, 0.0

    def imbalance(self, velocity: Value, force: Value) -> Value:
        """Return zero: a wall bears any force."""
        return 0.0 * force

    def mobility(self, slope: Value) -> Value:
        """Return zero."""
        return 0.0 * slope

    def drift(self, velocity: Value) -> Value:
        """Stay."""
        return 0.0


def _cube(params: ServerParams) -> Body:
    return Cube(params.object_mass, params.object_damping, period=params.period_s)


def _wall(params: ServerParams) -> Body:
    return Wall()


ENVIRONMENTS: Mapping[str, Callable[[ServerParams], Body]] = {"cube": _cube, "wall": _wall}


def make_environment(params: ServerParams) -> Body:
    """Return the environment ``params.environment`` names, at rest at the origin."""
    return ENVIRONMENTS[params.environment](params)
