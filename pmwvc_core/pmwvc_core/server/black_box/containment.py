# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One exchange with an environment, and the check of its answer.

The port asks once per step; whatever the environment does wrong, the port renders a matched damper
for that step and goes on. Waiting is not decided here: a ``Call`` runs the exchange, directly in a
simulation, in a thread of its own in a live server, and raises ``faults.Unanswered`` where it will
not wait any longer.
"""

from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

from pmwvc_core.numeric import Array, Flags
from pmwvc_core.server.black_box.faults import BadAnswer
from pmwvc_core.server.black_box.interface import BlackBox, Shown, Sloped, Storing

LARGEST_N = 1e6  # more is no force
R = TypeVar("R")
Call: TypeAlias = Callable[[Callable[[], Any]], Any]


def directly(exchange: Callable[[], R]) -> R:
    """Ask and wait as long as it takes."""
    return exchange()


class Reply(NamedTuple):
    """The checked answer of an environment."""

    velocity: Array  # (users, ..., dof) [m/s] of the avatars, as decoded
    force: Array  # (users, ..., dof) [N]; zero where it is not good
    good: Flags  # (users, ..., 1): where the force can be used
    stored: Any  # energy in the environment [J] or None
    shown: tuple[Array, Array] | None  # position and velocity of an object (..., dof)


class Asked:
    """An environment and the calls that are still to be passed on to it.

    ``notify`` is called by the port's thread, ``exchange`` perhaps by another one.
    """

    def __init__(self, environment: BlackBox) -> None:
        self.environment = environment
        self._pending: deque[tuple[str, tuple[Any, ...]]] = deque()

    def notify(self, call: str, *arguments: Any) -> None:
        """Have ``join`` or ``leave`` called before the next step, where there is one."""
        if hasattr(self.environment, call):
            self._pending.append((call, arguments))

    def exchange(
        self,
        start: Array,
        velocity: Array,
        *,
        period: float,
        weight: float,
        decode: Callable[[Array, Array], Array],
    ) -> Reply:
        """Pass joins and leaves on, solve the loop with the local slope if there is one, and step.

        Parameters
        ----------
        start
            Where the avatars are without their new velocity ``(users, ..., dof)`` [m].
        velocity
            Their new velocity without knowledge of a slope [m/s].
        period, weight
            Time step, and by how much of it the new velocity moves them [s].
        decode
            From F0 and G to the new velocity.
        """
        environment = self.environment
        while self._pending:
            name, arguments = self._pending.popleft()
            getattr(environment, name)(*arguments)
        if isinstance(environment, Sloped):
            line = np.broadcast_arrays(start, *environment.local(start, weight))[1:]
            force, slope = (_signal(each, start, "local") for each in line)
            if not np.isfinite(force + slope).all():
                raise BadAnswer("returned a slope from local that is not finite")
            velocity = decode(force, np.maximum(slope, 0.0))
        position = start + weight * velocity
        position.flags.writeable = velocity.flags.writeable = False
        force = _signal(environment.step(position, velocity, period), start)
        good = np.all(np.abs(force) <= LARGEST_N, axis=-1, keepdims=True)  # false for NaN
        return Reply(
            velocity,
            np.where(good, force, 0.0),
            good,
            _stored(environment),
            self.shown(start.shape[1:]),
        )

    def shown(self, shape: tuple[int, ...]) -> tuple[Array, Array] | None:
        """Return position [m] and velocity [m/s] of the object, None where it shows none."""
        if not isinstance(self.environment, Shown):
            return None
        found = self.environment.position, self.environment.velocity
        try:
            position, velocity = (np.array(np.broadcast_to(each, shape), float) for each in found)
        except (TypeError, ValueError):
            raise BadAnswer(f"shows its object otherwise than by an array {shape}") from None
        if not np.isfinite(position + velocity).all():
            raise BadAnswer(f"shows its object at {position}: must be finite")
        return position, velocity


def _signal(value: Any, like: Array, name: str = "step") -> Array:
    try:
        array = np.asarray(value)
        if np.iscomplexobj(array):
            raise BadAnswer(f"returned complex numbers from {name}")
        array = np.asarray(array, dtype=float)
    except (TypeError, ValueError):
        raise BadAnswer(f"returned {type(value).__name__} from {name}") from None
    if array.shape != like.shape:
        raise BadAnswer(f"returned shape {array.shape} from {name}, not {like.shape}")
    return array


def _stored(environment: BlackBox) -> Any:
    if not isinstance(environment, Storing):
        return None
    energy = np.asarray(environment.energy, dtype=float)
    if not np.isfinite(energy).all():
        raise BadAnswer(f"gave energy = {energy}: must be finite")
    energy = np.maximum(energy, 0.0)
    return energy if energy.size > 1 else energy.item()
