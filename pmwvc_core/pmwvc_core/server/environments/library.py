# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments by name: the library, and entry points of the group ``pmwvc.environments``.

A laboratory adds an environment by installing a package of its own that names a factory
``EnvironmentSetup -> BlackBox`` in that group; nothing here changes. Nothing is known of it but
its answers, and it is imported only when it is made.
"""

from collections.abc import Mapping
from functools import partial

from pmwvc_core.errors import ParameterError
from pmwvc_core.params import ServerParams
from pmwvc_core.plugins import PluginGroup
from pmwvc_core.server.black_box.interface import BlackBox, EnvironmentSetup
from pmwvc_core.server.cube import Body
from pmwvc_core.server.environments import active_wall, cube, hunt_crossley, wall
from pmwvc_core.server.environments.record import Environment

LIBRARY: Mapping[str, Environment] = {
    record.name: record
    for record in (
        cube.RECORD,
        wall.RECORD,
        wall.WITH_SLOPE,
        hunt_crossley.RECORD,
        active_wall.RECORD,
    )
}
PLUGINS = PluginGroup(
    "pmwvc.environments",
    "server.environment",
    "an environment",
    calls=("step",),
    own=tuple(LIBRARY),
)


def environment_of(name: str) -> Environment:
    """Return an environment by name; one of another package has only what holds for any."""
    if name in LIBRARY:
        return LIBRARY[name]
    return Environment(
        name=name,
        words="An environment of another package.",
        linear="wall",
        make=partial(PLUGINS.make, name),
        own_energy=lambda params: (
            f"whether environment {name!r} has energy of its own is not known"
        ),
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


def make_black_box(setup: EnvironmentSetup) -> BlackBox:
    """Make the environment ``setup.server.environment`` names, at rest.

    Raises
    ------
    ParameterError
        If there is no such environment (naming those there are), if it cannot be imported or made
        (with the reason), or if what is made is not an environment.
    """
    return environment_of(setup.server.environment).make(setup)


def make_body(params: ServerParams) -> Body:
    """Return the body of the environment ``params.environment`` names, at rest at the origin.

    Raises
    ------
    ParameterError
        If it is known as a black box only.
    """
    make = environment_of(params.environment).body
    if make is None:
        known = ", ".join(name for name, record in LIBRARY.items() if record.body)
        raise ParameterError(
            f"server.environment = {params.environment!r}: needs controller = pmwvc with "
            f"server.coupling = unknown; here there are {known}"
        )
    return make(params)
