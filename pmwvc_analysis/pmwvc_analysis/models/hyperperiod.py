# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A loop stepped on the identity, once around its hyperperiod: its states before and after.

A state is any number of both ends that answers the motion of devices and object in proportion, and
what packets under way say of it. Every state and every input is one in a column of its own; in a
column more nothing is, and in two more all of them are at once, weighted: the answers there have
to be the sum of the others. What answers by less than in proportion (energies) is no state.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.models.elements import Path, as_columns, elements, leaves, planted, repeated
from pmwvc_analysis.models.linear import NonlinearError
from pmwvc_analysis.models.links import CUT, SIGNALS, Link, size_of
from pmwvc_analysis.models.loop import Loop
from pmwvc_analysis.models.places import Places, State
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.vectors import Vector
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario

OUTPUTS = ("x", "xd", "f")
ONE = 2.0**-40  # of a unit, in SI units: limits are far away, and scaling is exact
LESS = 2.0**-20  # of the second weighted column
SUPERPOSED = 1e-9  # relative: what differs by more is not linear
ROUNDING = 1e-14  # of numbers that are not zero at rest
Under = tuple[Link, int, str, int]  # link, when sent, signal, axis


class Hyperperiod(Loop):
    """A loop with its states; see :class:`.loop.Loop` for the parameters.

    Attributes
    ----------
    names
        The states: name and axis, those of packets under way last.
    places
        Where they are, and what object and contacts are called.
    """

    def __init__(
        self, scenario: Scenario, *, live: bool = False, weights: Sequence[int] = ()
    ) -> None:
        super().__init__(scenario, live=live, weights=weights)
        self._rest, self.places = self.s, Places(scenario, self.lines)
        self._under_way: dict[State, Under] = {
            (f"{line.name}.{way}.{signal}[{past}]", axis): (link, past, signal, axis)
            for line in self.lines
            for way, link in (("up", line.up), ("down", line.down))
            for past in link.past
            for signal in SIGNALS
            for axis in range(size_of(scenario, way, signal, self.dof))
        }
        self._carried: dict[State, Path] = {}
        self._find()

    @property
    def names(self) -> list[State]:
        """The states."""
        return [*self._carried, *self._under_way]

    def around(
        self, *, inputs: bool = False, outputs: bool = False, rounds: int = 1, one: float = ONE
    ) -> tuple[Array, dict[str, Array]]:
        """Step around the hyperperiod.

        Parameters
        ----------
        inputs
            Whether columns follow for each user's force in each tick, along each axis.
        outputs
            Whether outputs are wanted.
        rounds
            How often; with inputs and outputs, once.
        one
            Amplitude of the unit of every state and input, in SI units.

        Returns
        -------
        rows : ndarray
            ``(runs, states, columns)``: the states at the end.
        read : dict
            ``x``, ``xd``, ``f``: user by user, tick by tick, axis by axis; empty where none are
            wanted.
        """
        if (asked := (inputs, rounds, one)) != self._went:
            self._go(*asked)
        names = [f"{line.name}.{{}}" for line in self.lines for _ in range(self.ticks * self.dof)]
        return self.ended(rounds), {
            name: self.rows([v for values in of for v in values], [n.format(name) for n in names])
            for name, of in self._read.items()
            if outputs
        }

    def _go(self, inputs: bool, rounds: int, one: float) -> None:
        """Step around as :meth:`around` says, and keep what is read."""
        users, ticks = range(len(self.lines)), self.ticks
        self.begin(len(users) * ticks if inputs else 0, one)
        read: dict[str, list[list[Any]]] = {name: [[] for _ in users] for name in OUTPUTS}
        for tick in range(rounds * ticks):
            forces = self.still
            if inputs:
                forces = [self._inputs(user * ticks + tick) for user in users]
            for user, values in enumerate(self.advance(tick, forces)):
                for name, value in zip(OUTPUTS, values, strict=True):
                    read[name][user] += value
        self._went, self._read = (inputs, rounds, one), read

    def begin(self, inputs: int, one: float = ONE) -> None:
        """Set every state to one in a column of its own, with as many more for inputs."""
        self._one, self._states = one, len(self.names)
        self._width = self._states + inputs * self.dof
        rng = np.random.default_rng(self._width)
        signs = rng.choice([-2.0, 1.0, 3.0], self._width)
        self._weights = signs * rng.uniform(0.5, 1.0, self._width)
        units = {state: self._unit(column) for column, state in enumerate(self.names)}
        self.s = self.places.followed(
            planted(
                repeated(self._rest, self._columns),
                {path: units[state] for state, path in self._carried.items()},
            )
        )
        self.p = repeated(self._p, self._columns)
        for line in self.lines:
            for link in (line.up, line.down):
                own = {
                    under[1:]: units[state]
                    for state, under in self._under_way.items()
                    if under[0] is link
                }
                link.begin(self._columns, own)

    @property
    def _columns(self) -> int:
        return self._width + 3

    def _unit(self, column: int) -> Any:
        values = np.zeros((self._columns, self.runs))
        values[column] = self._one
        values[-2], values[-1] = self._one * self._weights[column] * np.array([[1.0], [LESS]])
        return elements(values.ravel())

    def _inputs(self, index: int) -> Vector:
        """Return an input that is one along each axis."""
        first = self._states + index * self.dof
        return tuple(self._unit(first + axis) for axis in range(self.dof))

    def cut(self, link: Link, first: int) -> list[Any]:
        """Cut a link: what is sent goes into the list returned, and inputs come in instead."""
        sent: list[Any] = []

        def relay(packet: Packet) -> Packet:
            comes: dict[str, Any] = {}
            for signal in CUT:
                comes[signal] = self._inputs(first + len(sent) // self.dof)
                sent.extend(getattr(packet, signal))
            return packet._replace(**comes)

        link.relay = relay
        return sent

    def ended(self, rounds: int = 1) -> Array:
        """Return the states after so many hyperperiods, ``(runs, states, columns)``."""
        values = leaves(self.s)
        ends = [values[path] for path in self._carried.values()]
        index = {state: j for j, state in enumerate(self.names)}
        shifts = []
        for state, (link, past, signal, axis) in self._under_way.items():
            later = past + rounds * self.ticks
            if later >= 0:
                ends.append(getattr(link.packets[later], signal)[axis])
            else:
                ends.append(0.0)
                name = state[0].replace(f"[{past}]", f"[{later}]")
                shifts.append((index[state], index[name, axis]))
        found = self.rows(ends, [name for name, _ in self.names])
        for new, old in shifts:
            found[:, new, old] = 1.0
        return found

    def rows(self, values: Sequence[Any], names: Sequence[str] = ()) -> Array:
        """Return signals as rows over all states and inputs, ``(runs, signals, columns)``.

        Raises
        ------
        NonlinearError
            If superposition does not hold.
        """
        whole = self._answers(values)
        rows, together = whole[:, : self._width], whole[:, -2]
        size = np.einsum("c,scr->sr", np.abs(self._weights), np.abs(rows))
        largest = size.max(axis=0, initial=0.0)
        off = np.abs(np.einsum("c,scr->sr", self._weights, rows) - together)
        wrong = np.any(off > SUPERPOSED * largest, axis=1)
        if wrong.any():
            bad = {names[j] if names else "packet" for j in np.flatnonzero(wrong).tolist()}
            raise NonlinearError(
                f"{self.scenario.name}: superposition does not hold for "
                f"{', '.join(sorted(bad))}; there is no linear model; use 'pmwvc simulate'"
            )
        return rows.transpose(2, 0, 1).copy()

    def _answers(self, values: Sequence[Any]) -> Array:
        """Return by how much signals differ from rest, ``(signals, columns, runs)``, per unit."""
        found = np.empty((len(values), self._columns, self.runs))
        for index, value in enumerate(values):
            found[index] = as_columns(value, self._columns, self.runs)
        rest = found[:, self._width : self._width + 1]
        moved = found - rest
        return np.where(np.abs(moved) <= ROUNDING * np.abs(rest), 0.0, moved / self._one)

    def _find(self) -> None:
        """Find the states: those that the motion of devices and object sets in motion."""
        self._p = self.p
        places, moving = self.places.of(self._rest), self.places.moving(self.dof)
        states, found = moving, True
        while found:
            self._carried = {state: path for state, path in places.items() if state in states}
            self._go(inputs=False, rounds=1, one=ONE)
            values = leaves(self.s)
            others = [state for state in places if state not in self._carried]
            answers = self._answers([values[places[state]] for state in others])
            large, small = np.abs(answers[:, -2]), np.abs(answers[:, -1])
            answer = np.any(small > large * LESS**1.5, axis=1).tolist()
            new = {state for state, is_one in zip(others, answer, strict=True) if is_one}
            states, found = states | new, bool(new)
