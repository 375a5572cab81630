# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of a scenario, stepped tick by tick in the order of the simulator, or with the phases
of a live session (:data:`pmwvc_core.frame.schedule.LIVE`). Links have a constant delay; there are
no limits and no brakes.
"""

import dataclasses
import itertools
from collections.abc import Sequence

from pmwvc_analysis.models.line import Line, two_sided
from pmwvc_analysis.models.linear import axes_of, require_linear
from pmwvc_analysis.models.links import modelled_ticks
from pmwvc_analysis.models.rest import playouts_of, rest_of, set_paces
from pmwvc_core.frame.assembly import server_step_of
from pmwvc_core.numeric import Value
from pmwvc_core.scenario.scenario import Scenario


class Loop:
    """Both ends of a scenario and the links in between, brought to rest up to tick 0.

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
    ticks, dof
        Length of the hyperperiod; axes of the model: one where all axes have the same model.
    step, server
        The server's step, and the ports within.
    playouts
        Those of the strict channel by link; at the server there is one per port.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        live: bool = False,
        weights: Sequence[int] = (),
    ) -> None:
        require_linear(scenario)
        self.scenario, self.tick_s = scenario, scenario.tick_s
        self._tick_ns = round(scenario.tick_s * 1e9)
        self.ticks, self.dof = modelled_ticks(scenario), axes_of(scenario)
        server, ports = scenario.server, itertools.count()
        if not scenario.coupling.black_box and scenario.environment.body is None:
            server = dataclasses.replace(server, environment="wall")  # a black box only
        users = tuple(map(two_sided, scenario.users))
        modelled = dataclasses.replace(scenario, users=users, server=server)
        self.lines = [
            Line(modelled, i, ports=list(itertools.islice(ports, n)), dof=self.dof, live=live)
            for i, n in enumerate(weights or [1] * len(users))
        ]
        self.serve = self.lines[0].serve
        users = tuple(line.user for line in self.lines for _ in line.ports)
        self.step = server_step_of(dataclasses.replace(modelled, users=users), dof=self.dof)
        self.server = self.step.server
        for port in self.server.ports:
            port.brake = None
        self.playouts = playouts_of(self.lines, self.step)
        rest = rest_of(scenario, self.lines, self.ticks, live=live)
        self._start, still = rest.start, [0.0] * len(self.lines)
        for tick in range(rest.start, 0):
            if tick == rest.settled:
                set_paces(self.playouts, rest.paces)
            self.advance(tick, still)

    def advance(self, tick: int, forces: Sequence[Value]) -> list[tuple[Value, Value, Value]]:
        """Go one tick on under the hands' forces; return x, xd and f of every user."""
        number = tick - self._start
        at = tick, number, number * self._tick_ns
        for line in self.lines:
            line.send(*at)
            for packet in line.up.collect(tick):
                for port in line.ports:
                    self.step.deliver(port, packet, at[2])
        if self.serve.due(tick):
            answers, _ = self.step.tick(at[2], [()] * len(self.server.ports))
            for line in self.lines:
                line.down.send(tick, answers[line.ports[0]])
        return [line.step(*at, force) for line, force in zip(self.lines, forces, strict=True)]
