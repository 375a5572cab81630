# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments by name: the library, and entry points of the group ``pmwvc.environments``.

A laboratory adds an environment by installing a package of its own that names a factory
``EnvironmentSetup -> Environment`` in that group; nothing here changes.
"""

from collections.abc import Callable, Mapping

from pmwvc_core.plugins import PluginGroup
from pmwvc_core.server.black_box.hunt_crossley import HuntCrossley
from pmwvc_core.server.black_box.interface import Environment, EnvironmentSetup
from pmwvc_core.server.black_box.touch import ActiveWall, FreeCube, SlopedWall, Wall

LIBRARY: Mapping[str, Callable[[EnvironmentSetup], Environment]] = {
    "cube": FreeCube,
    "wall": Wall,
    "wall_with_slope": SlopedWall,
    "hunt_crossley": HuntCrossley,
    "active_wall": ActiveWall,
}
PLUGINS = PluginGroup(
    "pmwvc.environments",
    "server.environment",
    "an environment",
    calls=("step",),
    own=tuple(LIBRARY),
)


def require(name: str) -> None:
    """Refuse an environment that is neither in the library nor installed; none is imported.

    Raises
    ------
    ParameterError
        Naming those there are.
    """
    if name not in LIBRARY:
        PLUGINS.required(name)


def make_black_box(setup: EnvironmentSetup) -> Environment:
    """Make the environment ``setup.server.environment`` names, at rest.

    Raises
    ------
    ParameterError
        If there is no such environment (naming those there are), if it cannot be imported or made
        (with the reason), or if what is made is not an environment.
    """
    name = setup.server.environment
    if name in LIBRARY:
        return LIBRARY[name](setup)
    made: Environment = PLUGINS.make(name, setup)
    return made
