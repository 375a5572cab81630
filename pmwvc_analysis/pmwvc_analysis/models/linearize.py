# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact linear model of a scenario: the laws of a session, perturbed.

Both ends and the devices are brought to rest, where all signals are zero. Then every state and
every packet under way is set to one in a column of its own, and all columns are stepped side by
side once around the hyperperiod (:mod:`.hyperperiod`). What the states are
at the end is a row each of the transition matrix, on the states that matter: those that are
not read, not driven, or present twice are left out. None of that changes an eigenvalue other than
zero, nor what follows from the inputs. Structure counts, not size: a state is left out where its
entries are exactly zero, or two rows exactly equal, in every run.

Not here: motions that are no instability (:mod:`.rigid`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.models.hyperperiod import Hyperperiod
from pmwvc_analysis.models.motions import rigid
from pmwvc_analysis.models.outside import checked
from pmwvc_analysis.models.variation import lengths
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario


class Output(NamedTuple):
    """One lifted output y = C z + D f; rows, and columns of D, by
    ``(user * ticks + tick) * dof + axis``.
    """

    state: Array  # C, (users * ticks * dof, n)
    through: Array  # D, (users * ticks * dof, users * ticks * dof)


@dataclass(frozen=True)
class Linear:
    """The linear model of a scenario whose numbers may be columns."""

    loop: Hyperperiod
    columns: dict[tuple[str, int], int]  # of every state, by its name and axis
    rows: Array  # (runs, states, states and inputs), the states after the hyperperiod
    read: dict[str, Array]  # (runs, signals, states and inputs), what was read of them
    placed: frozenset[str]  # names of what a uniform motion is given by

    @property
    def states(self) -> list[str]:
        """Names of the n states."""
        several = self.loop.dof > 1
        return [f"{name}, axis {axis}" if several else name for name, axis in self.columns]

    @property
    def users(self) -> list[str]:
        """Names of the users."""
        return [line.name for line in self.loop.lines]

    @property
    def ticks(self) -> int:
        """Length of the hyperperiod in ticks."""
        return self.loop.ticks

    @property
    def matrices(self) -> Array:
        """A of every run, ``(runs, n, n)``."""
        return self.rows[:, :, : len(self.columns)]

    @property
    def transition(self) -> Array:
        """A of the first run, ``(n, n)``."""
        return np.asarray(self.matrices[0])

    @property
    def inputs(self) -> Array:
        """B of the first run, ``(n, inputs)``, per N of a hand pushing the device."""
        return self.rows[0, :, len(self.columns) :]

    @property
    def outputs(self) -> dict[str, Output]:
        """What was read of the first run; see :meth:`.hyperperiod.Hyperperiod.around`."""
        n = len(self.columns)
        return {name: Output(y[0, :, :n], y[0, :, n:]) for name, y in self.read.items()}

    @cached_property
    def rigid(self) -> list[rigid.Family]:
        """Motions that are no instability; see :mod:`.rigid`."""
        return rigid.families(self)

    @cached_property
    def left(self) -> Array:
        """A of every run on the quotient by rigid motions."""
        return rigid.quotient(self.matrices, self.rigid)

    def radii(self) -> Array:
        """Return the spectral radius of every run on that quotient."""
        return rigid.radius(self.left)


def linearize(
    scenario: Scenario, *, live: bool = False, weights: Sequence[int] = (), outputs: bool = False
) -> Linear:
    """Return the linear model of a scenario; see :class:`.loop.Loop` for what is asked. Its inputs
    are left out. Raises what :func:`.outside.checked` raises.
    """
    loop_of = kept_loop.__wrapped__ if any(lengths(scenario)) else kept_loop
    loop = loop_of(scenario, live, tuple(weights))
    return model_of(loop, *loop.around(outputs=outputs))


@lru_cache(maxsize=8)
def kept_loop(scenario: Scenario, live: bool, weights: tuple[int, ...]) -> Hyperperiod:
    """Return a loop without columns: one for all that is asked of it in a row."""
    return checked(scenario, live=live, weights=weights)


def model_of(loop: Hyperperiod, rows: Array, read: dict[str, Array]) -> Linear:
    """Return the model of what was stepped, on the states that matter."""
    entries = loop.names
    moving = {loop.places.body, f"{loop.places.body}d"}
    moving |= {f"{line.name}.device.{x}" for line in loop.lines for x in ("x", "xd")}
    moving |= {loop.places.deflection(index) for index in range(len(loop.lines))}
    moving |= {name for name, _ in entries if name.endswith(".local.x")}  # springs
    kept, (left, *signals) = reduced(
        rows, list(read.values()), always=lambda j: entries[j][0] in moving
    )
    columns = {entries[j]: index for index, j in enumerate(kept)}
    placed = moving & {name for name, _ in columns}
    outputs = dict(zip(read, signals, strict=True))
    return Linear(loop, columns, left, outputs, frozenset(placed))


def reduced(
    rows: Array, read: Sequence[Array], *, always: Callable[[int], bool]
) -> tuple[list[int], list[Array]]:
    """Return the states that matter, and on them the matrices given.

    Parameters
    ----------
    rows
        ``(runs, n, n and inputs)``: the states after a step.
    read
        ``(runs, signals, n and inputs)``: what is read of them otherwise.
    """
    n = rows.shape[1]
    whole = [rows.copy(), *(each.copy() for each in read)]
    filled = [np.any(each != 0.0, axis=0) for each in whole]  # entries other than zero in any run
    kept = list(range(n))
    while True:
        twins = _twins(whole[0], kept, always)
        for each, entries in zip(whole, filled, strict=True):
            for twin, first in twins.items():
                each[:, :, first] += each[:, :, twin]
                each[:, :, twin] = 0.0
                entries[:, [first, twin]] = np.any(each[:, :, [first, twin]] != 0.0, axis=0)
        still = [j for j in kept if j not in twins]
        moved = filled[0][still]  # (still, n and inputs)
        own = np.zeros_like(moved)
        own[np.arange(len(still)), still] = True
        columns = still + list(range(n, rows.shape[2]))
        driven = np.any((moved & ~own)[:, columns], axis=1)
        others = moved & ~(own & (whole[0][0][still] == 1.0))  # a sum that only it reads is none
        seen = np.any(np.concatenate([others, *filled[1:]]), axis=0)
        left = [
            j
            for j, is_driven in zip(still, driven, strict=True)
            if always(j) or (is_driven and seen[j])
        ]
        gone = list(set(still) - set(left))
        for each, entries in zip(whole, filled, strict=True):
            each[:, :, gone] = 0.0
            entries[:, gone] = False
        if left == kept:
            break
        kept = left
    columns = kept + list(range(n, rows.shape[2]))
    found, *outputs = (each[:, :, columns] for each in whole)
    return kept, [found[:, kept], *outputs]


def _twins(rows: Array, kept: list[int], always: Callable[[int], bool]) -> dict[int, int]:
    """Return states that are equal to an earlier one after every step."""
    first: dict[bytes, list[int]] = {}  # by their rows in the first run
    found = {}
    for j in kept:
        alike = first.setdefault((rows[0, j] + 0.0).tobytes(), [])
        earlier = next((i for i in alike if np.array_equal(rows[:, i], rows[:, j])), None)
        if earlier is None:
            alike.append(j)
        elif not always(j):
            found[j] = earlier
    return found
