# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The closed loop of blocks, stepped once around the hyperperiod on rows.

The order of events at a tick is that of the simulator: masters send, the server takes what has
arrived and answers, masters take the newest answer, hands and devices go on. A live session has
the same order with the phases of :data:`pmwvc_core.frame.LIVE`.
"""

import math
from collections.abc import Sequence

import numpy as np
from oracle.linear_model.blocks import Block
from oracle.linear_model.channel import Channel, Times, delay_ticks
from oracle.linear_model.ports import PORTS, Port
from oracle.linear_model.server import Server

from pmwvc_analysis.models.linear import require_linear
from pmwvc_core.errors import PmwvcError
from pmwvc_core.frame import AT_ONCE, LIVE
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario, User

LONGEST = 20000  # ticks of a hyperperiod


def hyperframe_ticks(scenario: Scenario) -> int:
    """Return the least common multiple of all frames and the server's period [ticks]."""
    return math.lcm(scenario.period_ticks, *(user.master.rate_drop for user in scenario.users))


def answer_phase(user: User, *, live: bool) -> int:
    """Return the tick of a frame at which the master takes an answer."""
    schedule = LIVE if live else AT_ONCE
    return schedule.answer_tick(tick_s=user.master.tick_s, rate_drop=user.master.rate_drop)


def serve_phase(scenario: Scenario, *, live: bool) -> int:
    """Return the tick of its period at which the server steps."""
    schedule = LIVE if live else AT_ONCE
    return schedule.server_tick(tick_s=scenario.tick_s, period_ticks=scenario.period_ticks)


class Line:
    """One user with the links both ways.

    Parameters
    ----------
    user, scenario
        Parameters.
    serve
        When the server steps.
    ticks
        Length of the hyperperiod.
    live
        Whether the phases are those of a live session.
    """

    def __init__(
        self, user: User, scenario: Scenario, *, serve: Times, ticks: int, live: bool
    ) -> None:
        tick_s, m = scenario.tick_s, user.master.rate_drop
        phase = answer_phase(user, live=live)
        self.name = user.name
        self.port: Port = PORTS[scenario.controller](user, tick_s=tick_s, phase=phase)
        self.frame, self.answer, self.serve = Times(m, 0), Times(m, phase), serve
        self.up = Channel(
            self.frame,
            serve,
            delay=delay_ticks(user.link_up, tick_s=tick_s, live=live),
            ticks=ticks,
            signals=self.port.signals,
        )
        self.delay_down = delay_ticks(user.link_down, tick_s=tick_s, live=live)
        self.down = Channel(
            serve,
            self.answer,
            delay=self.delay_down,
            ticks=ticks,
            signals=self.port.heard,
        )

    def ages(self) -> list[int]:
        """Return how old packets are when the server reads them [ticks]."""
        return self.up.ages(self.serve)

    def received_at(self, tick: int) -> int:
        """Return when the answer was sent that the master has at a tick."""
        return self.serve.last(self.answer.last(tick) - self.delay_down)


class Loop:
    """All blocks of a scenario.

    Parameters
    ----------
    scenario
        Numbers may be columns ``(runs, 1)``; delays, periods and counts are the same for all.
    live
        Phases of a live session instead of the simulator's.
    weights
        How many users like it each user stands for; see :mod:`.groups`.

    Attributes
    ----------
    ticks
        Length of the hyperperiod.
    names
        Of the states.
    """

    def __init__(
        self, scenario: Scenario, *, live: bool = False, weights: Sequence[int] = ()
    ) -> None:
        require_linear(scenario)
        self.scenario, self.tick_s = scenario, scenario.tick_s
        period = scenario.period_ticks
        self.ticks = hyperframe_ticks(scenario)
        if self.ticks > LONGEST:
            raise PmwvcError(
                f"{scenario.name}: frames and server period fit together only after {self.ticks} "
                f"ticks, more than {LONGEST}; choose rate_drop and period_s with common factors"
            )
        self.serve = Times(period, serve_phase(scenario, live=live))
        self.lines = [
            Line(user, scenario, serve=self.serve, ticks=self.ticks, live=live)
            for user in scenario.users
        ]
        self.server = Server(scenario, weights or [1] * len(scenario.users))
        self._blocks: list[tuple[str, Block]] = [("", self.server.body)]
        for line, seat in zip(self.lines, self.server.seats, strict=True):
            inner = [(line.name + "." + name, block) for name, block in line.port.blocks.items()]
            up, down = (f"{line.name}.up.", line.up), (f"{line.name}.down.", line.down)
            self._blocks += [*inner, (f"{line.name}.seat.", seat), up, down]
        self.names = [prefix + name for prefix, block in self._blocks for name in block.names]

    def around(self, *, inputs: bool) -> tuple[Array, dict[str, list[list[Array]]]]:
        """Step once around the hyperperiod.

        Parameters
        ----------
        inputs
            Whether rows also have a column for each user's force in each tick.

        Returns
        -------
        rows : ndarray
            ``(runs, states, width)``: the states at the end.
        outputs : dict
            ``x``, ``xd``, ``f``: per user, per tick, a row.
        """
        states, users = len(self.names), len(self.lines)
        width = states + (users * self.ticks if inputs else 0)
        unit = self.begin(width)
        outputs: dict[str, list[list[Array]]] = {
            name: [[] for _ in self.lines] for name in ("x", "xd", "f")
        }
        nothing = np.zeros((1, width))
        for tick in range(self.ticks):
            columns = [states + user * self.ticks + tick for user in range(users)]
            forces = [unit[j : j + 1] if inputs else nothing for j in columns]
            for user, signals in enumerate(self.advance(tick, forces)):
                for name, row in zip(outputs, signals, strict=True):
                    outputs[name][user].append(row)
        rows = self.ended()
        runs = max(len(row) for row in rows)
        stacked = np.stack([np.broadcast_to(row, (runs, width)) for row in rows], axis=1)
        return stacked, outputs

    def begin(self, width: int) -> Array:
        """Give every state its own row; return the unit rows ``(width, width)``."""
        unit = np.eye(width)
        place = 0
        for _, block in self._blocks:
            block.state = [unit[j : j + 1] for j in range(place, place + len(block.names))]
            place += len(block.names)
        return unit

    def advance(self, tick: int, forces: Sequence[Array]) -> list[tuple[Array, Array, Array]]:
        """Go one tick on under the hands' forces; return x, xd and f of every user."""
        self._packets(tick)
        return [line.port.step(force) for line, force in zip(self.lines, forces, strict=True)]

    def ended(self) -> list[Array]:
        """Return the rows of all states."""
        return [row for _, block in self._blocks for row in block.state]

    def _packets(self, tick: int) -> None:
        """Send, serve and receive, where it is time."""
        for line in self.lines:
            if line.frame.due(tick):
                line.up.send(tick, line.port.send())
        if self.serve.due(tick):
            answers = self.server.step([line.up.take(tick) for line in self.lines])
            for line, answer in zip(self.lines, answers, strict=True):
                line.down.send(tick, [answer[name] for name in line.port.heard])
        for line in self.lines:
            if line.answer.due(tick):
                since = line.received_at(tick) - line.received_at(tick - line.answer.period)
                line.port.on_packet(line.down.take(tick), since)

    def motion(
        self,
        x: list[Array],
        xd: list[Array],
        *,
        x_o: Array,
        xd_o: Array,
        e: list[Array] | None = None,
    ) -> Array:
        """Return the state ``(runs, n)`` of a uniform motion without forces.

        Parameters
        ----------
        x, xd
            Position [m] and velocity [m/s] of every device at tick 0, as columns.
        x_o, xd_o
            Those of the object; its position is that of the server's last step.
        e
            Deflections [m] of contacts that exert no force; else zero.
        """
        values = [x_o, xd_o][: len(self.server.body.names)]
        last = (self.serve.phase - self.serve.period) * self.tick_s
        offsets = e or [0.0 * x_o] * len(x)
        for line, seat, at, rate, offset in zip(
            self.lines, self.server.seats, x, xd, offsets, strict=True
        ):
            u = line.port.wave(rate)
            carried = np.where((seat.stiffness == 0.0) & (seat.damping == 0.0), 0.0, xd_o)
            now = x_o - last * carried + offset  # of the avatar, as if it moved between steps, too
            rise = self.tick_s * carried
            last_received = now + rise * line.received_at(-1)
            values += [*line.port.steady(at, rate, last_received), *seat.steady(u, offset)]
            nothing = 0.0 * u
            at_rate = {"x": (at, rate * self.tick_s), "xd": (rate, nothing), "u": (u, nothing)}
            heard = {"x_s": (now, rise), "v": (u, nothing), "f": (nothing, nothing)}
            for channel, known, names in (
                (line.up, at_rate, line.port.signals),
                (line.down, heard, line.port.heard),
            ):
                values += channel.steady(
                    [known[name][0] for name in names], [known[name][1] for name in names]
                )
        runs = max(len(value) for value in values)
        return np.concatenate([np.broadcast_to(v, (runs, 1)) for v in values], axis=1)
