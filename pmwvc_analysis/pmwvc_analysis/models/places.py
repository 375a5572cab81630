# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Where in the tuples of both ends a state may be, and which numbers follow from others."""

from typing import TypeAlias

import numpy as np

from pmwvc_analysis.models.elements import Path, leaves, lifted, text_of
from pmwvc_analysis.models.ends import Ends
from pmwvc_analysis.models.links import Line
from pmwvc_core.law.server.contacts import offset_of
from pmwvc_core.law.vectors import plus
from pmwvc_core.scenario.scenario import Scenario

State: TypeAlias = tuple[str, int]  # name and axis
# Of counts and jumps: without any, nothing reads them.
WATCHING = ("still_s", "slow_s", "way_m")
OFFSET = lifted(offset_of)


class Places:
    """The numbers of both ends of a scenario."""

    def __init__(self, scenario: Scenario, lines: list[Line]) -> None:
        self._scenario, self._lines = scenario, lines
        self._box = scenario.coupling.black_box
        self._gone = {port for line in lines for port in line.ports[1:]}

    @property
    def body(self) -> str:
        """Name of the object's position; its velocity has a d more."""
        return (
            "server.environment.body.environment.body.x"
            if self._box and self._scenario.environment.movable
            else "server.environment.body.x"
        )

    def deflection(self, index: int) -> str:
        """Return the name of the deflection of a user's contact."""
        return f"{self._contact(self._lines[index].ports[0])}.springs.deflection"

    def _contact(self, port: int) -> str:
        if self._box:
            return f"server.environment.body.environment.visitors.{port}.contact"
        return f"server.environment.ports.{port}.avatar.contact"

    def moving(self, dof: int) -> frozenset[State]:
        """Return the positions and velocities of devices and object."""
        names = {f"{line.name}.device.{x}" for line in self._lines for x in ("x", "xd")}
        if self._scenario.environment.movable:
            names |= {self.body, f"{self.body}d"}
        return frozenset((name, axis) for name in names for axis in range(dof))

    def of(self, rest: Ends) -> dict[State, Path]:
        """Return what may be a state, by name and axis; equal users have one."""
        return {
            self._state(path): path
            for path, value in leaves(rest).items()
            if path[-1] not in WATCHING and np.all(np.isfinite(value)) and not self._follows(path)
        }

    def _state(self, path: Path) -> State:
        name, axis = text_of(path)
        kind, user = path[:2]
        if kind == "server":
            return name, axis
        inside, axis = text_of(path[2:])
        line = self._lines[int(user)]
        return f"{line.name}.{'device.' if kind == 'devices' else ''}{inside}", axis

    def _follows(self, path: Path) -> bool:
        """Tell whether a number is another one's copy, or follows from others."""
        if path[:2] == ("server", "guests"):
            return path[2] in self._gone
        if path[:3] == ("server", "environment", "ports"):
            return path[3] in self._gone or path[4] == "x_s"
        if not self._box or path[:3] != ("server", "environment", "body"):
            return False
        own = path[3:]
        if own[0] == "users":
            return own[1] in self._gone or own[2] in ("x", "f")
        if own[:2] == ("environment", "visitors"):
            return own[2] in self._gone or own[3] == "at"
        return own[0] in ("x", "xd")

    def followed(self, s: Ends) -> Ends:
        """Put avatars where contacts and object are; equal users are with the first of them."""
        server, environment = s.server, s.server.environment
        guests, ports, box = list(server.guests), list(environment.ports), environment.body
        body = box.environment.body if self._box else box
        visitors = list(box.environment.visitors) if self._box else []
        users = list(box.users) if self._box else []
        for first, *others in (line.ports for line in self._lines):
            contact = visitors[first].contact if self._box else ports[first].avatar.contact
            x_s = plus(body.x, OFFSET(contact))
            ports[first] = ports[first]._replace(x_s=x_s)
            if self._box:
                visitors[first] = visitors[first]._replace(at=x_s)
                users[first] = users[first]._replace(x=x_s, f=ports[first].avatar.f)
            for each in (guests, ports, visitors, users):
                for other in others if each else ():
                    each[other] = each[first]
        if self._box:
            inside = box.environment._replace(visitors=tuple(visitors))
            box = box._replace(x=body.x, xd=body.xd, environment=inside, users=tuple(users))
        environment = environment._replace(ports=tuple(ports), body=box)
        return s._replace(server=server._replace(guests=tuple(guests), environment=environment))
