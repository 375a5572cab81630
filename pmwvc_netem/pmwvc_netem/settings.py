# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The relay's parameters: which users, through which links.

``users`` gives each user two links, ``user1/up`` and ``user1/down``, whose topics are relative to
the node's namespace. ``link.up`` and ``link.down`` hold for all users, ``user1.link.up`` for one.
Every setting of a link may change while running; the last word counts: a change of
``link.up.delay_s`` goes to all users, and a ``preset`` replaces all settings of all users.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from rclpy.node import Node

from pmwvc_core.errors import ParameterError, RecordingError
from pmwvc_core.network import effects
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.params import LinkParams, Spec, Validated, specs
from pmwvc_core.params.fields import parameter
from pmwvc_core.runtime.parameter_values import values_of
from pmwvc_core.runtime.parameters import (
    ParameterBinding,
    declare_names,
    declare_value,
    pass_on,
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
        self._node = node
        self._listener = listener
        self._binding = ParameterBinding(node)
        self._all: dict[str, LinkParams] = {}  # by direction
        self.seed: int = declare_value(node, "seed", SEED, 1)
        preset = self._binding.declare("", PresetParams, self._use_preset).preset
        self.users = declare_names(node, "users", ["user1"], "names of the users, two links each")
        if not self.users:
            raise ParameterError("users is empty: name at least one user")
        self.setups = self._of_users(preset)

    def _of_users(self, preset: str) -> list[LinkSetup]:
        setups = []
        for number, direction in enumerate(DIRECTIONS):
            defaults = getattr(PRESETS[preset], direction) if preset != "none" else None
            prefix = f"link.{direction}"
            common = self._declare_link(prefix, partial(self._pass_on, direction), defaults)
            each = []
            for index, user in enumerate(self.users):
                name, near, far = f"{user}/{direction}", user, f"server/{user}"
                ends = (near, far) if direction == "up" else (far, near)
                source, target = (f"{end}/wave_{direction}" for end in ends)
                listener = partial(self._listener, name)
                params = self._declare_link(f"{user}.{prefix}", listener, common)
                setups.append(LinkSetup(name, source, target, (self.seed, index, number), params))
                each.append(params)
            # those for all users get the values that all users have in common
            shared = {
                name: getattr(each[0], name)
                for name in specs(LinkParams)
                if len({getattr(params, name) for params in each}) == 1
            }
            self._all[direction] = replace(common, **shared)
            set_together(self._node, values_of(prefix, self._all[direction]))
        return setups

    def _declare_link(
        self, prefix: str, listener: Callable[[LinkParams], None], defaults: LinkParams | None
    ) -> LinkParams:
        check = partial(_check, prefix)
        return self._binding.declare(prefix, LinkParams, listener, defaults=defaults, check=check)

    def _pass_on(self, direction: str, new: LinkParams) -> None:
        """Hand what changed for all users to each of them."""
        old, self._all[direction] = self._all[direction], new
        for user in self.users:
            pass_on(self._node, [user], f"link.{direction}", old, new)

    def _use_preset(self, new: PresetParams) -> None:
        if new.preset == "none":
            return
        for direction in DIRECTIONS:
            params = getattr(PRESETS[new.preset], direction)
            for start in ("", *(f"{user}." for user in self.users)):
                set_together(self._node, values_of(f"{start}link.{direction}", params))


def _check(prefix: str, params: LinkParams) -> None:
    try:
        effects.check(params)
    except RecordingError as error:
        raise ParameterError(f"{prefix}.trace_file: {error}") from None
    except ParameterError as error:
        raise ParameterError(f"{prefix}.{error}") from None
