# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end of a session as others see it, between steps."""

import math
from collections.abc import Sequence
from typing import Any

from pmwvc_core.ends.forms import value
from pmwvc_core.ends.inbox import End
from pmwvc_core.frame.rows import PortRow, Presence, ServerRow
from pmwvc_core.law.server.server_port import environment_energies, port_shown
from pmwvc_core.law.server_step import Server
from pmwvc_core.numeric import Value
from pmwvc_core.plant.task import Task, offset

PRESENCES = tuple(Presence)  # by the numbers of the law


class ServerView(End):
    """What is read of a server: its state ``s``, parameters ``p`` and ``inboxes``."""

    s: Server
    p: Any
    _task: Task
    _accounts: Sequence[str]

    @property
    def presence(self) -> list[Presence]:
        """State of every user."""
        return [PRESENCES[guest.presence] for guest in self.s.guests]

    @property
    def x_o(self) -> Value:
        """Position of the object [m]."""
        return value(self.s.environment.body.x)

    @property
    def target_m(self) -> Value:
        """Where the object is to be brought [m]."""
        time_s = self.s.task_s
        return value(offset(max(time_s, 0.0) if time_s < math.inf else 0.0, self._task))

    def avatar(self, user: int) -> tuple[Value, Value]:
        """Return where a user's avatar is [m], and its force on the object [N]."""
        port = self.s.environment.ports[user]
        return value(port.x_s), value(port.avatar.f)

    def offset(self, user: int) -> Value:
        """Return how far an avatar is from its device without a force [m]."""
        return value(self.s.environment.ports[user].offset)

    def learned(self, user: int) -> float | None:
        """Return (K T + 2B)/b of what a user touches, where its port learns it."""
        p, s = self.p.environment, self.s.environment
        return float(port_shown(p, s, user).learned) if getattr(p, "learns", False) else None

    def _row(self) -> ServerRow:
        """Return all of it, with the energies that the environment counts by name."""
        p, e = self.p.environment, self.s.environment
        kinetic, potential, *energies = environment_energies(p, e)
        ports = []
        for user, port in enumerate(e.ports):
            a, shown = port.avatar, port_shown(p, e, user)
            signals = value(port.x_s), value(a.xd), value(a.f), value(a.u), value(shown.v_s)
            ports.append(PortRow(*signals, port.u_j, port.v_j, shown.touches))
        return ServerRow(
            value(e.body.x),
            value(e.body.xd),
            self.target_m,
            kinetic,
            potential,
            e.dissipated_j,
            ports,
            tuple(self.presence),
            dict(zip(self._accounts, energies, strict=False)),
        )
