# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments by name: the shared cube, and a wall that does not move.

A wall is the cube nailed down: the same faces and contact laws, no motion. These are the bodies
whose equations the couplings know; other environments are black boxes (``black_box``).
"""

from collections.abc import Callable, Mapping

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Value
from pmwvc_core.params import ServerParams
from pmwvc_core.server.cube import Body, Cube
from pmwvc_core.state import Stateful


class Wall(Stateful):
    """An object that never moves: whatever the force, velocity zero, no energy taken."""

    SIGNALS = "x xd"

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
    """Return the environment ``params.environment`` names, at rest at the origin.

    Raises
    ------
    ParameterError
        If it is a black box, which only a wave port with ``coupling = unknown`` can use.
    """
    if params.environment not in ENVIRONMENTS:
        raise ParameterError(
            f"server.environment = {params.environment!r}: needs controller = pmwvc with "
            f"server.coupling = unknown; here there are {', '.join(ENVIRONMENTS)}"
        )
    return ENVIRONMENTS[params.environment](params)
