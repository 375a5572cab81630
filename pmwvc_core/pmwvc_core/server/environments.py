# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments by name: the library, and entry points of the group ``pmwvc.environments``, each a
factory ``EnvironmentSetup -> BlackBox``. Nothing is known of one but its answers, and it is
imported only when it is made.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pkgutil import resolve_name
from typing import Any

from pmwvc_core.law.black_box.hunt_crossley import MetSoftBody, SoftBody, SoftBodyParams
from pmwvc_core.law.black_box.touched import FreeCube, MetObject, Swing, Wall
from pmwvc_core.law.motion import Body, BodyLaw, body_law
from pmwvc_core.params import ServerParams
from pmwvc_core.plugins import PluginGroup, Record
from pmwvc_core.server.black_box import EnvironmentSetup


@dataclass(frozen=True, kw_only=True)
class Environment(Record):
    """The properties of an environment."""

    # as a black box, from parameters, users and axes: the state at rest, by whose type the
    # families of :mod:`pmwvc_core.law.black_box` choose its laws, and what they go by
    made: Callable[[ServerParams, int, int], tuple[Any, Any]] | None = None
    # or made when it is asked for: a :class:`pmwvc_core.server.black_box.BlackBox`, whose contacts
    # are its own and may slip
    outside: Callable[[EnvironmentSetup], Any] | None = None
    known: bool = False  # whether every coupling knows its equations; else a black box only
    movable: bool = False  # whether it is an object that moves freely (``server.object_mass``)
    # whether it reports its slope or answers an impedance, with which the loop is solved
    sloped: bool = False
    with_slope: str | None = None  # name of the same one that does; None where there is none
    spring: bool = False  # whether each user touches a spring and damper that stand still
    contact_law: bool = True  # whether reports give K and B of the users' contacts with it
    # frequency at which it moves by itself [Hz]; 0: not at all
    drive_hz: Callable[[ServerParams], float] = lambda params: 0.0
    # why it may give out energy of its own; empty where it has none
    own_energy: Callable[[ServerParams], str] = lambda params: ""


def _object(
    server: ServerParams, users: int, axes: int, *, kind: Any, mass: bool = False
) -> tuple[Any, BodyLaw]:
    moved, damping = (server.object_mass, server.object_damping) if mass else (math.inf, 0.0)
    rest, law = (0.0,) * axes, body_law(moved, damping, server.period_s)
    return kind(Body(rest, rest)), law


def _wall(
    server: ServerParams, users: int, axes: int, *, driven: bool = False
) -> tuple[Wall, Swing]:
    drive, rest = server.active_wall, (0.0,) * axes
    amplitude = (drive.amplitude_m if driven else 0.0, *rest[1:])
    return Wall(Body(rest, rest), 0.0), Swing(amplitude, 2.0 * math.pi * drive.frequency_hz)


def _soft(
    server: ServerParams, users: int, axes: int, *, kind: Any = SoftBody
) -> tuple[Any, SoftBodyParams]:
    soft, rest, face_m = server.hunt_crossley, (0.0,) * axes, 0.5 * server.object_size_m
    params = SoftBodyParams(soft.exponent, soft.damping, face_m)
    return kind((0.0,) * users, Body(rest, rest)), params


_cube = partial(_object, mass=True)
_WALL: dict[str, Any] = {"made": _wall, "spring": True}
_MET: dict[str, Any] = {"sloped": True, "linear": "wall_with_impedance"}
_RECORDS = (
    Environment(
        name="cube", made=partial(_cube, kind=FreeCube), linear="cube", known=True, movable=True
    ),
    Environment(
        name="wall", linear="wall", known=True, with_slope="wall_with_slope", **_WALL
    ),
    Environment(name="wall_with_slope", linear="wall_with_slope", sloped=True, **_WALL),
    Environment(
        name="cube_with_impedance", made=partial(_cube, kind=MetObject), movable=True,
        **_MET | {"linear": "cube_with_impedance"},
    ),
    Environment(
        name="wall_with_impedance", made=partial(_object, kind=MetObject), spring=True, **_MET
    ),
    Environment(
        name="hunt_crossley_with_impedance", made=partial(_soft, kind=MetSoftBody),
        contact_law=False, **_MET,
    ),
    # a soft body that stands still, F = K d^n (1 + c d')
    Environment(name="hunt_crossley", made=_soft, linear="wall", sloped=True, contact_law=False),
    # driven along axis 0: it gives out the energy of its drive
    Environment(
        name="active_wall", made=partial(_wall, driven=True), linear="wall", contact_law=False,
        drive_hz=lambda p: p.active_wall.frequency_hz if p.active_wall.amplitude_m > 0.0 else 0.0,
        own_energy=lambda p: "its environment is driven" * (p.active_wall.amplitude_m > 0.0),
    ),
    # imported only when they are made:
    Environment(
        name="body", outside=lambda setup: resolve_name("pmwvc_core.scenes.body:Box")(setup)
    ),
    Environment(
        name="mujoco", contact_law=False, own_energy=lambda p: "a scene may fall, or be driven",
        outside=lambda setup: resolve_name("pmwvc_core.scenes.mujoco_scene:MujocoScene")(setup),
    ),
)  # fmt: skip
LIBRARY: Mapping[str, Environment] = {record.name: record for record in _RECORDS}
PLUGINS = PluginGroup(
    "pmwvc.environments", "server.environment", "an environment", calls=(("step", "meet"),),
    own=tuple(LIBRARY),
)  # fmt: skip


def environment_of(name: str) -> Environment:
    """Return an environment by name; one of another package has only what holds for any."""
    why = f"whether environment {name!r} has energy of its own is not known"
    unknown = Environment(
        name=name, outside=partial(PLUGINS.make, name), linear="wall", own_energy=lambda p: why
    )
    return LIBRARY.get(name, unknown)
