# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A loop stepped on the identity, once around its hyperperiod: its states before and after.

States are the signals that both ends carry from tick to tick (:mod:`pmwvc_core.state`), and what
controllers read of the packets under way.
"""

from collections.abc import Iterator, Sequence
from typing import Any

from pmwvc_analysis.models.identity import ONE, Identity
from pmwvc_analysis.models.linear import NonlinearError
from pmwvc_analysis.models.links import SIGNALS, Link
from pmwvc_analysis.models.loop import Loop
from pmwvc_analysis.models.variation import lengths
from pmwvc_core.numeric import Array, Value
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.state import Stateful

OUTPUTS = ("x", "xd", "f")
BOX = "asked.environment."  # of a black box, in the state of the server


class Hyperperiod(Loop):
    """A loop with its states; see :class:`.loop.Loop` for the parameters.

    Attributes
    ----------
    names
        Of the states, ``dof`` entries of the state vector each.
    batch
        Of the present round.
    """

    batch: Identity

    def __init__(
        self,
        scenario: Scenario,
        *,
        live: bool = False,
        weights: Sequence[int] = (),
    ) -> None:
        super().__init__(scenario, live=live, weights=weights)
        self._blocks = list(self._ends())
        unsaid = {type(end).__name__ for _, end in self._blocks if not isinstance(end, Stateful)}
        if unsaid:
            raise NonlinearError(
                f"{scenario.name}: controller = {scenario.controller}: {', '.join(unsaid)} does "
                "not declare its state (pmwvc_core.state)"
            )
        self._first_of = {  # of the contacts of equal users
            f"{owner}{port}.": f"{owner}{line.ports[0]}."
            for line in self.lines
            for port in line.ports[1:]
            for owner in ("ports.", f"{BOX}contacts.")
        }
        others = tuple(f"server.{port}" for port in self._first_of)
        self._carried = [name for name in self._values() if not name.startswith(others)]
        links = {
            f"{line.name}.{way}.": getattr(line, way)
            for line in self.lines
            for way in ("up", "down")
        }
        self._under_way: list[tuple[Link, int, str, str]] = [
            (link, past, signal, f"{prefix}{signal}[{past}]")
            for prefix, link in links.items()
            for past in link.past
            for signal in SIGNALS
        ]
        self.names = self._carried + [name for *_, name in self._under_way]
        # What is set to one: all that is carried, and the packets that are read this time.
        self._live = list(range(len(self._carried)))
        for index, (link, past, *_) in enumerate(self._under_way, start=len(self._carried)):
            if past in link.read:
                self._live.append(index)

    @property
    def units(self) -> list[int]:
        """Columns of the states that are set to one."""
        return [j * self.dof + axis for j in self._live for axis in range(self.dof)]

    def _ends(self) -> Iterator[tuple[str, Any]]:
        """Yield what carries signals, with the beginning of their names; equal users have one."""
        yield "server.", self.server
        for line in self.lines:
            yield f"{line.name}.device.", line.device
            yield f"{line.name}.", line.loop.controller
        for name, playout in self.playouts:
            yield f"{name}.played.", playout

    @property
    def _box(self) -> bool:
        return self.scenario.coupling.black_box

    @property
    def body(self) -> str:
        """Name of the object's position; its velocity has a d more."""
        cube = self._box and self.scenario.environment.movable
        return f"server.{BOX}body.x" if cube else "server.body.x"

    def deflection(self, index: int) -> str:
        """Return the name of the deflection of a user's contact."""
        port = self.lines[index].ports[0]
        if self._box:
            return f"server.{BOX}contacts.{port}.deflection"
        return f"server.ports.{port}.contact.deflection"

    def around(
        self,
        *,
        inputs: bool = False,
        outputs: bool = False,
        rounds: int = 1,
        one: float = ONE,
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
        users = range(len(self.lines))
        self.begin(len(users) * self.ticks if inputs else 0, one)
        read: dict[str, list[list[Value]]] = {n: [[] for _ in users] for n in OUTPUTS}
        for tick in range(rounds * self.ticks):
            forces = [self.batch.input(u * self.ticks + tick) if inputs else 0.0 for u in users]
            for user, values in enumerate(self.advance(tick, forces)):
                for name, value in zip(OUTPUTS, values, strict=True):
                    read[name][user].append(value)
        names = [f"{self.lines[user].name}.{{}}" for user in users for _ in range(self.ticks)]
        return self.ended(rounds), {
            name: self.batch.rows(
                [v for values in of for v in values], [n.format(name) for n in names]
            )
            for name, of in read.items()
            if outputs
        }

    def begin(self, inputs: int, one: float = ONE) -> None:
        """Set every state to one in a run of its own, with as many runs more for inputs."""
        self.batch = Identity(
            self.scenario.name,
            states=len(self.names),
            live=self._live,
            inputs=inputs,
            runs=max(lengths(self.scenario), default=1),
            dof=self.dof,
            one=one,
        )
        unit = {self.names[j]: self.batch.state(place) for place, j in enumerate(self._live)}
        for port in range(
            len(self.server.ports)
        ):  # joins anew; a black box is told at its next step
            self.server.join(port, self.batch.zero)
        if self._box:
            self.server.step([self.batch.zero] * len(self.server.ports))
        for prefix, block in self._blocks:
            own = {n[len(prefix) :]: unit[n] for n in self._carried if n.startswith(prefix)}
            block.set_signals(own)
        self._follow()
        for link, past, signal, name in self._under_way:
            setattr(link.packets[past], signal, unit.get(name, 0.0))

    def ended(self, rounds: int = 1) -> Array:
        """Return the states after so many hyperperiods, ``(runs, states, columns)``."""
        values, dof = self._values(), self.dof
        ends = [values[name] for name in self._carried]
        index = {name: j for j, name in enumerate(self.names)}
        shifts = []
        for link, past, signal, name in self._under_way:
            later = past + rounds * self.ticks
            if later >= 0:
                ends.append(getattr(link.packets[later], signal))
            else:
                ends.append(0.0)
                shifts.append((index[name], index[name.replace(f"[{past}]", f"[{later}]")]))
        found = self.batch.rows(ends, self.names)
        for new, old in shifts:
            for axis in range(dof):
                found[:, new * dof + axis, old * dof + axis] = 1.0
        return found

    def _values(self) -> dict[str, Value]:
        """Return everything that is carried from tick to tick, by name."""
        return {
            prefix + name: value
            for prefix, block in self._blocks
            for name, value in block.signals().items()
        }

    def _follow(self) -> None:
        """Put avatars where contacts and object are; equal users are with the first of them."""
        state = dict(self.server.snapshot())
        for name in state:
            for copy, first in self._first_of.items():
                if name.startswith(copy):
                    state[name] = state[first + name[len(copy) :]]
        x_o, at = state.get(f"{BOX}body.x", state["body.x"]), {}
        for i in range(len(self.server.ports)):
            own = state[f"ports.{i}.contact.deflection"]
            at[i] = x_o + state.get(f"{BOX}contacts.{i}.deflection", own)
            state[f"ports.{i}.x_s"] = at[i]
        if f"{BOX}at" in state:
            state[f"{BOX}at"] = at
        self.server.restore(state)
