# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of a scenario stepped on the identity, once around the hyperperiod.

Every state is set to one in a run of its own: an array ``(states, runs, dof)`` with parameters
``(runs, 1)``. The one is small, a power of two: limits are far away, and scaling is exact. One run
more has all of them at once, weighted: it has to be the sum of the others.

The order of events at a tick is that of the simulator: masters send, the server takes what has
arrived and answers, masters take the newest answer, hands and devices go on. A live session has
the same order with the two phases of :data:`pmwvc_core.frame.schedule.LIVE`.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.models.line import Line, two_sided
from pmwvc_analysis.models.linear import NonlinearError, axes_of, require_linear
from pmwvc_analysis.models.links import SIGNALS, Link, Times, hyperperiod_ticks, serve_phase
from pmwvc_analysis.models.variation import lengths
from pmwvc_core.controllers import make_server
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array, Value
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.state import Stateful
from pmwvc_core.transport.packet import FLAG_DIRECT

LONGEST = 20000  # ticks of a hyperperiod
ONE = 2.0**-40
SUPERPOSED = 1e-9  # relative: what differs by more is not linear
OUTPUTS = ("x", "xd", "f")
BOX = "asked.environment."  # of a black box, in the state of the server


class Loop:
    """Both ends of a scenario and the links in between.

    Parameters
    ----------
    scenario
        Numbers may be columns ``(runs, 1)``; delays, periods and counts are the same for all.
    live
        Phases of a live session instead of the simulator's.
    weights
        How many users like it each user stands for: so many avatars move together.

    Attributes
    ----------
    ticks, dof, runs
        Length of the hyperperiod; axes of the model: one where all axes have the same model.
    names
        Of the states, ``dof`` entries of the state vector each.
    """

    def __init__(
        self, scenario: Scenario, *, live: bool = False, weights: Sequence[int] = ()
    ) -> None:
        require_linear(scenario)
        self.scenario, self.tick_s = scenario, scenario.tick_s
        self.ticks = hyperperiod_ticks(scenario)
        if self.ticks > LONGEST:
            raise PmwvcError(
                f"{scenario.name}: frames and server period fit together only after {self.ticks} "
                f"ticks, more than {LONGEST}; choose rate_drop and period_s with common factors"
            )
        users = [two_sided(user) for user in scenario.users]
        ports = [user.server_impedance for user in users]
        self.dof = axes_of(scenario)
        self.runs = max(lengths(scenario), default=1)
        self.serve = Times(scenario.period_ticks, serve_phase(scenario, live=live))
        self.lines = [
            Line(user, scenario, serve=self.serve, dof=self.dof, ticks=self.ticks, live=live)
            for user in users
        ]
        self._line_of = [i for i, n in enumerate(weights or [1] * len(users)) for _ in range(n)]
        server = scenario.server
        if not self._box and scenario.environment.body is None:  # known as a black box only
            server = dataclasses.replace(server, environment="wall")
        self.server = make_server(
            scenario.controller,
            server,
            [users[i].contact for i in self._line_of],
            [ports[i] for i in self._line_of],
            dof=self.dof,
            sides=[users[i].side for i in self._line_of],
            baselines=[users[i].baseline for i in self._line_of],
        )
        self._join(1)
        # To tick 0 at rest, so long that every user has received an answer to a packet of its own.
        longest = max(self.serve.period, *(line.frame.period for line in self.lines))
        first = -3 * longest if not scenario.strict else -4 * self.ticks - 3 * longest
        for tick in range(first, 0):
            self.advance(tick, [0.0] * len(self.lines))
            for line in self.lines:
                for playout in line.playouts.values():
                    playout.forget_waits()
        ends: dict[str, Any] = {"server.": self.server}
        links: dict[str, Link] = {}
        for line in self.lines:
            name = line.name
            ends |= {f"{name}.device.": line.device, f"{name}.": line.controller}
            ends |= line.playouts
            links |= {f"{name}.up.": line.up, f"{name}.down.": line.down}
        unsaid = {type(end).__name__ for end in ends.values() if not isinstance(end, Stateful)}
        if unsaid:
            raise NonlinearError(
                f"{scenario.name}: controller = {scenario.controller}: {', '.join(unsaid)} does "
                "not declare its state (pmwvc_core.state)"
            )
        self._blocks: dict[str, Stateful] = ends
        self._copies = {
            f"{owner}{i}.": f"{owner}{self._line_of.index(of)}."
            for i, of in enumerate(self._line_of)
            if of in self._line_of[:i]
            for owner in ("ports.", f"{BOX}contacts.")
        }
        others = tuple(f"server.{port}" for port in self._copies)
        self._carried = [name for name in self._values() if not name.startswith(others)]
        self._under_way = [
            (link, past, signal, f"{prefix}{SIGNALS[signal]}[{past}]")
            for prefix, link in links.items()
            for past in link.past
            for signal in range(len(SIGNALS))
        ]
        self.names = self._carried + [name for *_, name in self._under_way]
        # What is set to one: all that is carried, and the packets that are read this time.
        self._live = list(range(len(self._carried)))
        for index, (link, past, *_) in enumerate(self._under_way, start=len(self._carried)):
            if past in link.read:
                self._live.append(index)
        self._weights: Array = np.zeros(0)  # of all runs in the last one

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
        port = self._line_of.index(index)
        if self._box:
            return f"server.{BOX}contacts.{port}.deflection"
        return f"server.ports.{port}.contact.deflection"

    def around(self, *, inputs: bool = False) -> tuple[Array, dict[str, Array]]:
        """Step once around the hyperperiod.

        Parameters
        ----------
        inputs
            Whether columns follow for each user's force in each tick, along each axis.

        Returns
        -------
        rows : ndarray
            ``(runs, states, columns)``: the states at the end.
        outputs : dict
            ``x``, ``xd``, ``f``: user by user, tick by tick, axis by axis.
        """
        users = range(len(self.lines))
        self.begin(len(users) * self.ticks if inputs else 0)
        outputs: dict[str, list[list[Value]]] = {n: [[] for _ in users] for n in OUTPUTS}
        for tick in range(self.ticks):
            forces = [self.unit(user * self.ticks + tick) if inputs else 0.0 for user in users]
            for user, values in enumerate(self.advance(tick, forces)):
                for name, value in zip(OUTPUTS, values, strict=True):
                    outputs[name][user].append(value)
        ends = self.ended()
        names = [f"{self.lines[user].name}.{{}}" for user in users for _ in range(self.ticks)]
        return ends, {
            name: self.rows([v for values in of for v in values], [n.format(name) for n in names])
            for name, of in outputs.items()
        }

    def begin(self, inputs: int) -> None:
        """Set every state to one in a run of its own, with as many runs more for inputs."""
        width = (len(self._live) + inputs) * self.dof
        rng = np.random.default_rng(width)
        self._weights = rng.choice([-2.0, 1.0, 3.0], width) * rng.uniform(0.5, 1.0, width)
        one = {self.names[j]: self._unit(index) for index, j in enumerate(self._live)}
        self._join(width + 1)
        for prefix, block in self._blocks.items():
            own = {n[len(prefix) :]: one[n] for n in self._carried if n.startswith(prefix)}
            block.set_signals(own)
        self._follow()
        for link, past, signal, name in self._under_way:
            packet = [*link.packets.get(past, (0.0, 0.0))]
            packet[signal] = one.get(name, 0.0)
            link.packets[past] = tuple(packet)

    def unit(self, index: int) -> Array:
        """Return an input that is one in runs of its own, along each axis."""
        return self._unit(len(self._live) + index)

    def _unit(self, index: int) -> Array:
        first, dof = index * self.dof, range(self.dof)
        unit = np.zeros((len(self._weights) + 1, 1, self.dof))
        for axis in dof:
            unit[[first + axis, -1], 0, axis] = ONE, ONE * self._weights[first + axis]
        return unit

    def advance(self, tick: int, forces: Sequence[Value]) -> list[tuple[Value, Value, Value]]:
        """Go one tick on under the hands' forces; return x, xd and f of every user."""
        for line in self.lines:
            if line.frame.due(tick):
                line.send(tick)
            line.play(tick, down=False)
        if self.serve.due(tick):
            self._serve(tick)
        for line in self.lines:
            line.play(tick, down=True)
            if line.answer.due(tick):
                line.receive(tick)
        return [line.step(force) for line, force in zip(self.lines, forces, strict=True)]

    def _serve(self, tick: int) -> None:
        """Take what has arrived, step the environment, answer."""
        received = [line.received(tick) for line in self.lines]
        packets = [received[i] for i in self._line_of]
        direct = self.server.flags & FLAG_DIRECT
        answers = self.server.step([packet[::-1] if direct else packet[0] for packet in packets])
        for i, line in enumerate(self.lines):
            port = self._line_of.index(i)
            line.down.send(tick, (answers[port], self.server.x_s[port]))

    def ended(self) -> Array:
        """Return the states after the hyperperiod, ``(runs, states, columns)``."""
        values, dof = self._values(), self.dof
        ends = [values[name] for name in self._carried]
        index = {name: j for j, name in enumerate(self.names)}
        shifts = []
        for link, past, signal, name in self._under_way:
            later = past + self.ticks
            if later >= 0:
                ends.append(link.packets[later][signal])
            else:
                ends.append(0.0)
                shifts.append((index[name], index[name.replace(f"[{past}]", f"[{later}]")]))
        found = self.rows(ends, self.names)
        for new, old in shifts:
            for axis in range(dof):
                found[:, new * dof + axis, old * dof + axis] = 1.0
        return found

    def rows(self, values: Sequence[Value], names: Sequence[str] = ()) -> Array:
        """Return signals as rows over all states and inputs, ``(runs, signals, columns)``.

        Raises
        ------
        NonlinearError
            If superposition does not hold.
        """
        width = len(self._weights)
        found = np.empty((self.runs, len(values) * self.dof, width + 1))
        for index, value in enumerate(values):
            shaped = np.broadcast_to(value, (width + 1, self.runs, self.dof))
            found[:, index * self.dof : (index + 1) * self.dof] = shaped.transpose(1, 2, 0)
        found /= ONE
        rows, together = found[..., :-1], found[..., -1]
        size = (np.abs(rows) @ np.abs(self._weights)).max(axis=1, keepdims=True, initial=0.0)
        wrong = np.any(np.abs(rows @ self._weights - together) > SUPERPOSED * size, axis=0)
        if wrong.any():
            bad = {
                names[j // self.dof] if names else "packet" for j in np.flatnonzero(wrong).tolist()
            }
            raise NonlinearError(
                f"{self.scenario.name}: superposition does not hold for {', '.join(sorted(bad))}; "
                "there is no linear model; use 'pmwvc simulate'"
            )
        states = len(self.names) * self.dof
        live = [j * self.dof + axis for j in self._live for axis in range(self.dof)]
        wide = np.zeros((self.runs, rows.shape[1], states + width - len(live)))
        wide[:, :, live + list(range(states, wide.shape[-1]))] = rows
        return wide

    def _values(self) -> dict[str, Value]:
        """Return everything that is carried from tick to tick, by name."""
        return {
            prefix + name: value
            for prefix, block in self._blocks.items()
            for name, value in block.signals().items()
        }

    def _join(self, width: int) -> None:
        """Let every user join at rest; an environment is notified at its next step."""
        zero = np.zeros((width, self.runs, self.dof))
        for port in range(len(self._line_of)):
            self.server.join(port, zero)
        if self._box:
            self.server.step([zero] * len(self._line_of))

    def _follow(self) -> None:
        """Put avatars where contacts and object are; equal users are with the first of them."""
        state = dict(self.server.snapshot())
        for name in state:
            for copy, first in self._copies.items():
                if name.startswith(copy):
                    state[name] = state[first + name[len(copy) :]]
        x_o, at = state.get(f"{BOX}body.x", state["body.x"]), {}
        for i in range(len(self._line_of)):
            own = state[f"ports.{i}.contact.deflection"]
            at[i] = x_o + state.get(f"{BOX}contacts.{i}.deflection", own)
            state[f"ports.{i}.x_s"] = at[i]
        if f"{BOX}at" in state:
            state[f"{BOX}at"] = at
        self.server.restore(state)
