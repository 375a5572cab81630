# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""An end stepped on the identity, once around the hyperperiod: what goes out of it, and its states
after, by its states before and what comes in.

A state is any number of the end that answers motion, or what packets say of it, in proportion.
Every state and every input is one in a column of its own; in a column more nothing is, and in
three more all of them are at once, weighted, with either sign: the answers have to be the sum of
the others. What answers by less than in proportion (energies) is no state. Of all states those
matter that are read and driven, those present twice once: entries are exactly zero or rows exactly
equal in every run, so leaving others out changes no eigenvalue other than zero, nor what follows
from the inputs.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from pmwvc_analysis.models import elements
from pmwvc_analysis.models.elements import Path
from pmwvc_analysis.models.ends import SIGNALS, End, Slot
from pmwvc_analysis.models.linear import NonlinearError
from pmwvc_core.numeric import Array, Flags, Integers

OUTPUTS = ("x", "xd", "f")
OF_DEVICES = (".device.x", ".device.xd")  # ends of names
MOVING = (*OF_DEVICES, ".body.x", ".body.xd")  # and of the object
PLACED = (*MOVING, ".deflection", ".local.x")  # and of springs: what gives a rigid motion
ONE = 2.0**-40  # of a unit, in SI units: limits are far away, and scaling is exact
LESS = 2.0**-20  # of the second weighted column
SUPERPOSED = 1e-9  # relative: what differs by more is not linear
ROUNDING = 1e-14  # of numbers that are not zero at rest
WATCHING = ("still_s", "slow_s", "way_m")  # of counts and jumps: without any, nothing reads them
StateName: TypeAlias = tuple[str, int]  # name and axis


class Signal(NamedTuple):
    """A number of a packet of the hyperperiod."""

    slot: Slot
    name: str  # of SIGNALS
    axis: int


class EndMatrix(NamedTuple):
    """One end, linear: ``matrix (runs, states, sent and read, states, came and forces)``."""

    states: list[StateName]
    came: list[Signal]
    sent: list[Signal]
    read: int  # rows of x, xd and f: by output, tick and axis
    matrix: Array


class Response:
    """What of an end answers; with the ``forces`` of a hand along each axis in every tick, and the
    motion read there, where they are asked for.
    """

    def __init__(self, end: End, forces: bool = False) -> None:
        self._end, self._rest, self._p = end, end.s, end.p
        self._forces = end.ticks * end.dof * forces
        self.came = [
            Signal(Slot(way, packet), name, axis)
            for way, each in enumerate(end.ways)
            for packet in range(len(each.arrivals(each.looked.phase, end.ticks)))
            for name, values in zip(SIGNALS, end.nothing, strict=True)
            for axis in range(len(values))
        ]
        self.paths: dict[StateName, Path] = {}
        self._find()

    def matrix(self, *, rounds: int = 1, one: float = ONE) -> EndMatrix:
        """Return the end over ``rounds`` hyperperiods, the same coming in again in each, with
        units of ``one`` in SI units; NonlinearError if superposition does not hold.
        """
        if self._went != (rounds, one):
            self._go(rounds, one)
        end, ends, sent = self._end, elements.leaves(self._end.s), list[Signal]()
        rows = [(name, ends[path]) for (name, _), path in self.paths.items()]
        for slot, packet in self._sent.items():
            for name in SIGNALS:
                for axis, value in enumerate(getattr(packet, name)):
                    sent.append(Signal(slot, name, axis))
                    rows.append((f"{end.name} {name}", value))
        read = list[tuple[str, Any]]()
        for place, name in enumerate(OUTPUTS if self._forces else ()):
            read += [(f"{end.name}.{name}", x) for tick in self._read for x in tick[place]]
        whole = np.concatenate([self._rows(rows), self._rows(read)], axis=1)
        return EndMatrix(list(self.paths), self.came, sent, len(read), whole)

    def _go(self, rounds: int = 1, one: float = ONE) -> None:
        """Step from every state and input at one in a column of its own."""
        end, n = self._end, len(self.paths)
        first = n + len(self.came)
        self._one, self._width = one, first + self._forces
        self._columns = self._width + 4
        rng = np.random.default_rng(self._width)
        signs = rng.choice([-2.0, 1.0, 3.0], self._width)
        self._weights = signs * rng.uniform(0.5, 1.0, self._width)
        units = {path: self._unit(column) for column, path in enumerate(self.paths.values())}
        begun = elements.planted(elements.repeated(self._rest, self._columns), units)
        end.s, end.p = end.followed(begun), elements.repeated(self._p, self._columns)
        came, self._sent, self._read = self._signals(n, rounds), dict[Slot, Any](), list[Any]()
        for tick in range(rounds * end.ticks):
            force = end.nothing[0]
            if self._forces and tick < end.ticks:
                force = tuple(self._unit(first + tick * end.dof + i) for i in range(end.dof))
            sent, read = end.step(tick, came, force)
            self._sent |= sent
            self._read.append(read)
        self._went = rounds, one

    def _signals(self, first: int, rounds: int) -> Any:
        """Return what comes in, one signal after the other."""
        found: dict[Slot, tuple[list[Any], ...]] = {}
        for column, (slot, name, _) in enumerate(self.came, start=first):
            parts = found.setdefault(slot, ([], [], []))
            parts[SIGNALS.index(name)].append(self._unit(column))
        whole = [len(way.arrivals(way.looked.phase, self._end.ticks)) for way in self._end.ways]
        return {
            Slot(way, packet + again * whole[way]): tuple(map(tuple, parts))
            for (way, packet), parts in found.items()
            for again in range(rounds)
        }

    def _unit(self, column: int) -> Any:
        """Return what is one in a column, and weighted in the two that have all at once."""
        values = np.zeros((self._columns, self._end.runs))
        values[column] = self._one
        values[-3:] = self._one * self._weights[column] * np.array([[1.0], [-1.0], [LESS]])
        return elements.elements(values.ravel())

    def _rows(self, signals: Sequence[tuple[str, Any]]) -> Array:
        """Return signals with their names as rows over all states and inputs, ``(runs, signals,
        columns)``.
        """
        whole = self._answers([value for _, value in signals])
        rows = whole[:, : self._width]
        sizes = np.einsum("c,scr->sr", np.abs(self._weights), np.abs(rows))
        expected = np.einsum("c,scr->sr", self._weights, rows)
        off = np.maximum(np.abs(expected - whole[:, -3]), np.abs(expected + whole[:, -2]))
        wrong = np.any(off > SUPERPOSED * sizes.max(axis=0, initial=0.0), axis=1)
        if wrong.any():
            bad = {signals[j][0] for j in np.flatnonzero(wrong).tolist()}
            raise NonlinearError(
                f"{self._end.scenario.name}: superposition does not hold for "
                f"{', '.join(sorted(bad))}; there is no linear model; use 'pmwvc simulate'"
            )
        return rows.transpose(2, 0, 1).copy()

    def _answers(self, values: Sequence[Any]) -> Array:
        """Return by how much signals differ from rest, ``(signals, columns, runs)``, per unit."""
        found = np.empty((len(values), self._columns, self._end.runs))
        for index, value in enumerate(values):
            found[index] = elements.as_columns(value, self._columns, self._end.runs)
        rest = found[:, self._width : self._width + 1]
        moved = found - rest
        return np.where(np.abs(moved) <= ROUNDING * np.abs(rest), 0.0, moved / self._one)

    def _find(self) -> None:
        """Find the states: those that motion and packets set in motion."""
        places = self._places()
        movable = self._end.scenario.environment.movable
        states = {name for name in places if name[0].endswith(MOVING if movable else OF_DEVICES)}
        while True:
            self.paths = {name: path for name, path in places.items() if name in states}
            self._go()
            values = elements.leaves(self._end.s)
            others = [name for name in places if name not in states]
            answers = self._answers([values[places[name]] for name in others])
            large, small = np.abs(answers[:, -3]), np.abs(answers[:, -1])
            answer = np.any(small > large * LESS**1.5, axis=1).tolist()
            new = {name for name, is_one in zip(others, answer, strict=True) if is_one}
            if not new:
                return
            states |= new

    def _places(self) -> dict[StateName, Path]:
        """Return where a state may be: at numbers that do not follow from others."""
        paths = [
            path
            for path, value in elements.leaves(self._rest).items()
            if path[-1] not in WATCHING and np.all(np.isfinite(value))
        ]
        marks = {path: 0.5 + number for number, path in enumerate(paths)}
        left = elements.leaves(self._end.followed(elements.planted(self._rest, marks)))
        return {self._end.name_of(path): path for path in paths if left[path] is marks[path]}


def placed(states: Iterable[StateName]) -> Flags:
    """Tell of every state whether it is one that gives a rigid motion ``(n,)``."""
    return np.array([name.endswith(PLACED) for name, _ in states], dtype=np.bool_)


def reduced(whole: Array, always: Flags) -> tuple[list[int], Array]:
    """Return the states that matter, and the matrix on them alone.

    ``whole`` is ``(runs, n and signals, n and inputs)``: the n states after a step, and what is
    read of them otherwise; ``always`` are ``(n,)`` states that matter in any case.
    """
    n, whole = len(always), whole.copy()
    filled = np.any(whole != 0.0, axis=0)  # entries other than zero in any run
    kept = np.arange(n)
    while True:
        twins = _twins(whole, kept, always)
        for twin, first in twins.items():
            whole[:, :, first] += whole[:, :, twin]
            filled[:, first] = np.any(whole[:, :, first] != 0.0, axis=0)
        still = np.setdiff1d(kept, list(twins))
        own = still[:, np.newaxis] == np.arange(whole.shape[2])
        columns = np.r_[still, n : whole.shape[2]]
        driven = np.any((filled[still] & ~own)[:, columns], axis=1)
        others = filled[still] & ~(own & (whole[0, still] == 1.0))  # a sum only it reads is none
        seen = others.any(axis=0) | filled[n:].any(axis=0)
        left = still[always[still] | (driven & seen[still])]
        gone = np.setdiff1d(kept, left)
        whole[:, :, gone], filled[:, gone] = 0.0, False
        if len(left) == len(kept):
            rows = np.r_[kept, n : whole.shape[1]]
            return kept.tolist(), whole[:, rows[:, np.newaxis], np.r_[kept, n : whole.shape[2]]]
        kept = left


def _twins(whole: Array, kept: Integers, always: Flags) -> dict[int, int]:
    """Return states that are equal to an earlier one after every step."""
    first: dict[bytes, int] = {}  # by their rows in every run
    return {
        j: earlier
        for j in kept.tolist()
        if (earlier := first.setdefault((whole[:, j] + 0.0).tobytes(), j)) != j and not always[j]
    }
