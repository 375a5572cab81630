# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The relay's parameters: which users, through which links.

``users`` gives each user two links, ``user1/up`` and ``user1/down``, whose topics are relative to
the node's namespace. At the start ``preset``, ``link.up`` and ``link.down`` hold for all users,
``user1.link.up`` for one. While running, the latter may change.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from rclpy.node import Node

from pmwvc_core.errors import ParameterError, RecordingError
from pmwvc_core.network import effects
from pmwvc_core.network.presets import DIRECTIONS, PRESETS
from pmwvc_core.params import LinkParams, Spec
from pmwvc_core.runtime.parameters import ParameterBinding, declare, declare_names, declare_value

SEED = Spec(int, "-", low=0, high=2**31 - 1, description="seed of all random numbers")
PRESET = Spec(
    str, choices=("none", *PRESETS),
    description="settings of all links by name; those given one by one take precedence",
)  # fmt: skip


@dataclass(frozen=True)
class LinkSetup:
    """One link: its topics, its random stream and its settings at the start."""

    name: str
    source: str
    target: str
    seed: tuple[int, int, int]
    params: LinkParams


def declare_settings(node: Node, listener: Callable[[str, LinkParams], None]) -> list[LinkSetup]:
    """Declare all parameters of the node and return the links; ParameterError if one is wrong.

    ``listener`` gets name and complete settings of a link after each accepted change, in the
    thread that serves parameters.
    """
    binding = ParameterBinding(node)
    seed = declare_value(node, "seed", SEED, 1)
    named = PRESETS.get(declare_value(node, "preset", PRESET, "none"))
    users = declare_names(node, "users", ["user1"], "names of the users, two links each")
    if not users:
        raise ParameterError("users is empty: name at least one user")
    found = []
    for number, way in enumerate(DIRECTIONS):
        defaults = declare(node, f"link.{way}", LinkParams, defaults=getattr(named, way, None))
        for index, user in enumerate(users):
            ends, name = (user, f"server/{user}"), f"{user}/{way}"
            source, target = (f"{ends[at]}/wave_{way}" for at in (number, 1 - number))
            prefix = f"{user}.link.{way}"
            params = binding.declare(
                prefix, LinkParams, partial(listener, name), defaults=defaults,
                check=partial(_check, prefix),
            )  # fmt: skip
            found.append(LinkSetup(name, source, target, (seed, index, number), params))
    return found


def _check(prefix: str, params: LinkParams) -> None:
    try:
        effects.check(params)
    except RecordingError as error:
        raise ParameterError(f"{prefix}.trace_file: {error}") from None
    except ParameterError as error:
        raise ParameterError(f"{prefix}.{error}") from None
