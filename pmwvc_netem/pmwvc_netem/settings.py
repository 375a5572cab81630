# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The relay's parameters: which users, through which links.

``users`` gives each user two links, ``user1/up`` and ``user1/down``, whose topics are relative to
the node's namespace. At the start ``link.up`` and ``link.down`` hold for all users,
``user1.link.up`` for one. While running, the latter may change, and a ``preset`` replaces all
settings of all users.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from rclpy.node import Node

from pmwvc_core.errors import ParameterError, RecordingError
from pmwvc_core.network import effects
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.params import LinkParams, Spec, Validated
from pmwvc_core.params.fields import parameter
from pmwvc_core.runtime.parameter_values import values_of
from pmwvc_core.runtime.parameters import (
    ParameterBinding,
    declare,
    declare_names,
    declare_value,
    set_together,
)

DIRECTIONS = ("up", "down")
SEED = Spec(int, "-", low=0, high=2**31 - 1, description="seed of all random numbers")


@dataclass(frozen=True)
class PresetParams(Validated):
    """Link settings for all users by name."""

    preset: str = parameter(
        "none",
        ("none", *PRESETS),
        "settings of all links by name; at the start those given one by one take precedence",
    )


@dataclass(frozen=True)
class LinkSetup:
    """One link: its topics, its random stream and its settings at the start."""

    name: str
    source: str
    target: str
    seed: tuple[int, int, int]
    params: LinkParams


class Settings:
    """All parameters of the relay; ParameterError where one given to the node is wrong.

    ``listener`` gets name and complete settings of a link after each accepted change, in the
    thread that serves parameters.
    """

    def __init__(self, node: Node, listener: Callable[[str, LinkParams], None]) -> None:
        self._node, self._listener, self._binding = node, listener, ParameterBinding(node)
        self._seed: int = declare_value(node, "seed", SEED, 1)
        preset = self._binding.declare("", PresetParams, self._use_preset).preset
        self._users = declare_names(node, "users", ["user1"], "names of the users, two links each")
        if not self._users:
            raise ParameterError("users is empty: name at least one user")
        named = PRESETS.get(preset)
        common = [
            declare(node, f"link.{way}", LinkParams, defaults=getattr(named, way, None))
            for way in DIRECTIONS
        ]
        self.setups = [
            self._setup(index, user, number, common[number])
            for number in range(len(DIRECTIONS))
            for index, user in enumerate(self._users)
        ]

    def _setup(self, index: int, user: str, number: int, common: LinkParams) -> LinkSetup:
        """Declare the settings of a user's link; those for all users are its defaults."""
        direction, ends = DIRECTIONS[number], (user, f"server/{user}")
        name, prefix = f"{user}/{direction}", f"{user}.link.{direction}"
        source, target = (f"{ends[at]}/wave_{direction}" for at in (number, 1 - number))
        params = self._binding.declare(
            prefix, LinkParams, partial(self._listener, name), defaults=common,
            check=partial(_check, prefix),
        )  # fmt: skip
        return LinkSetup(name, source, target, (self._seed, index, number), params)

    def _use_preset(self, new: PresetParams) -> None:
        if new.preset == "none":
            return
        for direction in DIRECTIONS:
            params = getattr(PRESETS[new.preset], direction)
            for user in self._users:
                set_together(self._node, values_of(f"{user}.link.{direction}", params))


def _check(prefix: str, params: LinkParams) -> None:
    try:
        effects.check(params)
    except RecordingError as error:
        raise ParameterError(f"{prefix}.trace_file: {error}") from None
    except ParameterError as error:
        raise ParameterError(f"{prefix}.{error}") from None
