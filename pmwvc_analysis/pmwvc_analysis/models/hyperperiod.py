# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A loop stepped on the identity, once around its hyperperiod: its states before and after.

A state is any number of both ends that answers the motion of devices and object in proportion, and
what packets under way say of it. Every state and every input is one in a column of its own; in a
column more nothing is, and in two more all of them are at once, weighted: the answers there have
to be the sum of the others. What answers by less than in proportion (energies) is no state.
"""

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from pmwvc_analysis.models import elements
from pmwvc_analysis.models.elements import Path
from pmwvc_analysis.models.ends import followed
from pmwvc_analysis.models.linear import NonlinearError
from pmwvc_analysis.models.links import SIGNALS
from pmwvc_analysis.models.loop import LinearLoop
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario

OUTPUTS = ("x", "xd", "f")
WAYS = ("up", "down")  # of packets
OF_DEVICES = (".device.x", ".device.xd")  # ends of names
MOVING = (*OF_DEVICES, ".body.x", ".body.xd")  # and of the object
PLACED = (*MOVING, ".deflection", ".local.x")  # and of springs: what gives a rigid motion
ONE = 2.0**-40  # of a unit, in SI units: limits are far away, and scaling is exact
LESS = 2.0**-20  # of the second weighted column
SUPERPOSED = 1e-9  # relative: what differs by more is not linear
ROUNDING = 1e-14  # of numbers that are not zero at rest
WATCHING = ("still_s", "slow_s", "way_m")  # of counts and jumps: without any, nothing reads them
StateName: TypeAlias = tuple[str, int]  # name and axis


class Hyperperiod(LinearLoop):
    """A loop with its states; see :class:`.loop.LinearLoop` for the parameters."""

    def __init__(self, *runs: Scenario, live: bool = False, weights: Sequence[int] = ()) -> None:
        super().__init__(*runs, live=live, weights=weights)
        self._rest, self._p, self._box = self.s, self.p, runs[0].coupling.black_box
        # The states, those of packets under way last, and where each is found.
        self.paths: dict[StateName, Path] = {}
        self._find()

    def around(
        self, *, inputs: bool = False, outputs: bool = False, rounds: int = 1, one: float = ONE
    ) -> tuple[Array, dict[str, Array]]:
        """Step around the hyperperiod, ``rounds`` times, with units of ``one`` in SI units.

        Columns are the states, and with ``inputs`` each user's force in each tick along each axis.
        Returns the states at the end, ``(runs, states, columns)``, and where ``outputs`` are
        wanted ``x``, ``xd``, ``f``: user by user, tick by tick, axis by axis (with one round).
        """
        if (asked := (inputs, rounds, one)) != self._went:
            self._go(*asked)
        ends = elements.leaves(self.s)
        after = self._rows([(name, ends[path]) for (name, _), path in self.paths.items()])
        read = {
            name: [
                (f"{line.user.name}.{name}", value)
                for user, line in enumerate(self.lines)
                for by_user in self._read
                for value in by_user[user][place]
            ]
            for place, name in enumerate(OUTPUTS if outputs else ())
        }
        return after, {name: self._rows(signals) for name, signals in read.items()}

    def _go(self, inputs: bool = False, rounds: int = 1, one: float = ONE) -> None:
        """Step from every state at one in a column of its own; keep what is read by tick."""
        users, ticks, n = range(len(self.lines)), self.ticks, len(self.paths)
        self._one, self._width = one, n + inputs * len(users) * ticks * self.dof
        self._columns = self._width + 3
        rng = np.random.default_rng(self._width)
        signs = rng.choice([-2.0, 1.0, 3.0], self._width)
        self._weights = signs * rng.uniform(0.5, 1.0, self._width)
        units = {path: self._unit(column) for column, path in enumerate(self.paths.values())}
        begun = elements.planted(elements.repeated(self._rest, self._columns), units)
        self.s = followed(begun, self.lines, self._box)
        self.p = elements.repeated(self._p, self._columns)
        self._read, forces = [], self.still
        for tick in range(rounds * ticks):
            if inputs:
                firsts = [n + (user * ticks + tick) * self.dof for user in users]
                forces = [tuple(map(self._unit, range(at, at + self.dof))) for at in firsts]
            self._read.append(self.advance(tick, forces))
        self._went = inputs, rounds, one

    def _unit(self, column: int) -> Any:
        """Return what is one in a column, and weighted in the two that have all at once."""
        values = np.zeros((self._columns, self.runs))
        values[column] = self._one
        values[-2], values[-1] = self._one * self._weights[column] * np.array([[1.0], [LESS]])
        return elements.elements(values.ravel())

    def _rows(self, signals: Sequence[tuple[str, Any]]) -> Array:
        """Return signals with their names as rows over all states and inputs, ``(runs, signals,
        columns)``; NonlinearError if superposition does not hold.
        """
        whole = self._answers([value for _, value in signals])
        rows, together = whole[:, : self._width], whole[:, -2]
        sizes = np.einsum("c,scr->sr", np.abs(self._weights), np.abs(rows))
        off = np.abs(np.einsum("c,scr->sr", self._weights, rows) - together)
        wrong = np.any(off > SUPERPOSED * sizes.max(axis=0, initial=0.0), axis=1)
        if wrong.any():
            bad = {signals[j][0] for j in np.flatnonzero(wrong).tolist()}
            raise NonlinearError(
                f"{self.scenario.name}: superposition does not hold for "
                f"{', '.join(sorted(bad))}; there is no linear model; use 'pmwvc simulate'"
            )
        return rows.transpose(2, 0, 1).copy()

    def _answers(self, values: Sequence[Any]) -> Array:
        """Return by how much signals differ from rest, ``(signals, columns, runs)``, per unit."""
        found = np.empty((len(values), self._columns, self.runs))
        for index, value in enumerate(values):
            found[index] = elements.as_columns(value, self._columns, self.runs)
        rest = found[:, self._width : self._width + 1]
        moved = found - rest
        return np.where(np.abs(moved) <= ROUNDING * np.abs(rest), 0.0, moved / self._one)

    def _find(self) -> None:
        """Find the states: those that the motion of devices and object sets in motion."""
        places = self._places()
        moving = MOVING if self.scenario.environment.movable else OF_DEVICES
        new = states = {
            state for state, path in places.items() if path[0] in WAYS or state[0].endswith(moving)
        }
        while new:
            self.paths = {state: path for state, path in places.items() if state in states}
            self._go()
            values = elements.leaves(self.s)
            others = [state for state in places if state not in states]
            answers = self._answers([values[places[state]] for state in others])
            large, small = np.abs(answers[:, -2]), np.abs(answers[:, -1])
            answer = np.any(small > large * LESS**1.5, axis=1).tolist()
            new = {state for state, is_one in zip(others, answer, strict=True) if is_one}
            states = states | new

    def _places(self) -> dict[StateName, Path]:
        """Return where a state may be: at numbers that do not follow from others."""
        paths = [
            path
            for path, value in elements.leaves(self._rest).items()
            if path[-1] not in WATCHING
            and np.all(np.isfinite(value))
            and (path[0] not in WAYS or path[-2] in SIGNALS)
        ]
        marks = {path: 0.5 + number for number, path in enumerate(paths)}
        marked = followed(elements.planted(self._rest, marks), self.lines, self._box)
        left = elements.leaves(marked)
        return {self._state(path): path for path in paths if left[path] is marks[path]}

    def _state(self, path: Path) -> StateName:
        if path[0] == "server":
            return elements.text_of(path)
        where, user = str(path[0]), self.lines[int(path[1])].user.name
        if where in WAYS:
            return f"{user}.{where}.{path[-2]}[{self.sent_at(path)}]", int(path[-1])
        inside, axis = elements.text_of(path[2:])
        return f"{user}.{'device.' if where == 'devices' else ''}{inside}", axis

    def sent_at(self, path: Path) -> int:
        """Return the tick at which a packet under way was sent."""
        where, user, place = path[:3]
        return int(getattr(self._rest, str(where))[user][place].tick)
