# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's end of a session as others see it, between steps; the distance between avatar and
device that joining may leave, in words.
"""

import math
from collections.abc import Sequence
from typing import Any

from pmwvc_core.ends.inbox import PortEnd, value
from pmwvc_core.frame import Presence, ServerRow
from pmwvc_core.law.server.server_port import environment_energies, port_shown
from pmwvc_core.law.server_step import Server
from pmwvc_core.numeric import Value
from pmwvc_core.plant.forces import Task, offset

LEAST_M = 1e-3  # avatars less far from their device are not reported


def why_kept(*, waves: bool, black_box: bool) -> str:
    """Return why a distance at joining stays, for a controller and an environment."""
    if not waves:
        return "this controller keeps the distance"
    if black_box:
        return "an environment known by its forces only has no face to stop at, so it cannot slide"
    return "it joined with the device inside the object, and slides to it once there is room"


def kept_words(distance_m: float, why: str) -> str:
    """Return the distance and why it stays; nothing below ``LEAST_M``."""
    if not distance_m > LEAST_M:
        return ""
    return f"avatar {1e3 * distance_m:.1f} mm from the device since joining: {why}"


class ServerView(PortEnd):
    """What is read of a server: its state ``s``, parameters ``p`` and ``inboxes``."""

    s: Server
    p: Any
    _task: Task
    _accounts: Sequence[str]

    @property
    def presence(self) -> list[Presence]:
        """State of every user."""
        return [Presence(guest.presence) for guest in self.s.guests]

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
        of_users = []
        for user, port in enumerate(e.ports):
            a, shown = port.avatar, port_shown(p, e, user)
            motion = map(value, (port.x_s, a.xd, a.f, a.u, shown.v_s))
            of_users.append((*motion, port.u_j, port.v_j, shown.touches))
        columns = zip(*of_users, strict=True)
        signals: dict[str, Any] = dict(zip(ServerRow._fields[-10:-2], columns, strict=True))
        accounts = dict(zip(self._accounts, energies, strict=False))
        of_object = value(e.body.x), value(e.body.xd), self.target_m
        sums, state = (kinetic, potential, e.dissipated_j), tuple(self.presence)
        return ServerRow(*of_object, *sums, **signals, state=state, accounts=accounts)
