# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments by name: the library, and entry points of the group ``pmwvc.environments``.

A laboratory adds an environment by installing a package of its own that names a factory
``EnvironmentSetup -> Environment`` in that group; nothing here changes.
"""

from collections.abc import Callable, Mapping
from importlib.metadata import EntryPoint, entry_points

from pmwvc_core.errors import FOREIGN, ParameterError, PmwvcError
from pmwvc_core.server.blackbox.faults import reason
from pmwvc_core.server.blackbox.hunt_crossley import HuntCrossley
from pmwvc_core.server.blackbox.interface import Environment, EnvironmentSetup
from pmwvc_core.server.blackbox.touch import ActiveWall, FreeCube, SlopedWall, Wall

GROUP = "pmwvc.environments"
LIBRARY: Mapping[str, Callable[[EnvironmentSetup], Environment]] = {
    "cube": FreeCube,
    "wall": Wall,
    "wall_with_slope": SlopedWall,
    "hunt_crossley": HuntCrossley,
    "active_wall": ActiveWall,
}


def installed() -> dict[str, EntryPoint]:
    """Return the installed plug-ins by name, without importing any."""
    return {point.name: point for point in sorted(entry_points(group=GROUP))}


def required(name: str) -> EntryPoint | None:
    """Return an installed plug-in, without importing it; None for one of the library.

    Raises
    ------
    ParameterError
        If there is none of this name; names those there are.
    """
    points = installed()
    if name in LIBRARY:
        return None
    if name not in points:
        raise ParameterError(
            f"server.environment = {name!r}: not installed; there are: "
            f"{', '.join([*LIBRARY, *points])}. "
            f"A plug-in is a package with an entry point in the group {GROUP!r}"
        )
    return points[name]


def make_black_box(setup: EnvironmentSetup) -> Environment:
    """Make the environment ``setup.server.environment`` names, at rest.

    Raises
    ------
    ParameterError
        If there is no such environment (naming those there are), if it cannot be imported or made
        (with the reason), or if what is made is not an environment.
    """
    name = setup.server.environment
    point = required(name)
    if point is None:
        return LIBRARY[name](setup)
    where = f"server.environment = {name!r} ({point.value})"
    try:
        factory = point.load()
    except FOREIGN as error:  # whatever a foreign package raises while it is imported
        raise ParameterError(f"{where} cannot be imported: {reason(error)}") from error
    try:
        environment: Environment = factory(setup)
    except PmwvcError:
        raise
    except FOREIGN as error:  # whatever a foreign factory raises
        raise ParameterError(f"{where} cannot be made: {reason(error)}") from error
    if not callable(getattr(environment, "step", None)):
        raise ParameterError(f"{where} is not an environment: it lacks step")
    return environment
