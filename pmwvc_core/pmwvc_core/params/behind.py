# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters given at a handle, as the avatar meets them behind the device's scale."""

from copy import copy
from typing import Any, TypeVar

from pmwvc_core.params.fields import Validated, groups, specs

# Behind a scale s a hand moves s times as far and pushes with 1/s of its force: powers of s.
BEHIND = {"m": 1, "m/s": 1, "N": -1, "N/s": -1, "N s/m": -2, "N/m": -2, "kg": -2}
P = TypeVar("P", bound=Validated)


def scaled(params: P, scale: float) -> P:
    """Return what is given at the handle as the avatar meets it; ranges hold at the handle."""
    if scale == 1.0:
        return params
    seen, kind = copy(params), type(params)
    of_file = "N" if getattr(params, "kind", "") == "playback_force" else "m"
    for name, spec in specs(kind).items():
        unit = spec.unit.removesuffix(" per unit of the file").replace("N or m", of_file)
        if power := BEHIND.get(unit):
            vars(seen)[name] = getattr(params, name) * scale**power
    vars(seen).update({name: scaled(getattr(params, name), scale) for name in groups(kind)})
    return seen


def strictest(one: P, other: P) -> P:
    """Return the smaller value of each limit."""
    kept = copy(one)
    vars(kept).update({name: min(getattr(one, name), getattr(other, name)) for name in vars(one)})
    return kept


def behind(name: str) -> Any:
    """Declare a property of a user: a group of parameters as the avatar meets it."""
    return property(lambda user: scaled(getattr(user, name), user.given_device.scale))
