# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The scene as markers for RViz and its relatives: object, avatars, target and forces, frame
``world``.

A picture of the last step, taken by another thread than the loop's; nothing here acts on the
session.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from pmwvc_core.frame.rows import Presence
from pmwvc_core.numeric import Value
from pmwvc_server.loop import ServerLoop

FRAME = "world"
AVATAR_M = 0.012  # diameter
ARROW_M_PER_N = 0.02
# Okabe and Ito's colours: distinguished by colour-blind people too.
COLORS = (
    (0.00, 0.45, 0.70),
    (0.84, 0.37, 0.00),
    (0.00, 0.62, 0.45),
    (0.80, 0.47, 0.65),
    (0.90, 0.62, 0.00),
    (0.34, 0.71, 0.91),
    (0.94, 0.89, 0.26),
    (0.00, 0.00, 0.00),
)


class Scene:
    """Builds the markers of one session, whose object has edges of ``size_m`` [m]. Axes that it
    does not have are drawn at zero.
    """

    def __init__(self, users: Sequence[str], *, size_m: float) -> None:
        self._users, self._size_m = list(users), size_m

    def markers(self, loop: ServerLoop, stamp: Any) -> MarkerArray:
        """Return the scene after the last step."""
        end, presence = loop.protocol, loop.protocol.presence
        size = self._size_m
        cube = _marker("object", 0, Marker.CUBE, stamp, (0.6, 0.6, 0.6), 0.8)
        cube.pose.position = _point(end.x_o)
        cube.scale = Vector3(x=size, y=size, z=size)
        target = _marker("target", 0, Marker.CUBE, stamp, (0.2, 0.7, 0.2), 0.25)
        target.pose.position = _point(end.target_m)
        target.scale = Vector3(x=1.02 * size, y=1.02 * size, z=1.02 * size)
        found = [cube, target]
        for user, name in enumerate(self._users):
            found += self._user(loop, user, name, presence[user], stamp)
        return MarkerArray(markers=found)

    def _user(
        self, loop: ServerLoop, user: int, name: str, presence: Presence, stamp: Any
    ) -> list[Marker]:
        """Return a user's avatar and the force it exerts on the object; nothing while absent."""
        color = COLORS[user % len(COLORS)]
        opacity = 0.4 if presence is Presence.DAMPING else 1.0
        avatar = _marker(f"{name}/avatar", user, Marker.SPHERE, stamp, color, opacity)
        force = _marker(f"{name}/force", user, Marker.ARROW, stamp, color, opacity)
        if presence is Presence.ABSENT:
            avatar.action = force.action = Marker.DELETE
            return [avatar, force]
        x, f = map(np.atleast_1d, loop.protocol.avatar(user))
        avatar.pose.position = _point(x)
        avatar.scale = Vector3(x=AVATAR_M, y=AVATAR_M, z=AVATAR_M)
        force.points = [_point(x), _point(x + f * ARROW_M_PER_N)]
        force.scale = Vector3(x=0.004, y=0.008, z=0.008)
        return [avatar, force]


def _point(value: Value) -> Point:
    x, y, z = [*np.atleast_1d(value), 0.0, 0.0][:3]
    return Point(x=float(x), y=float(y), z=float(z))


def _marker(
    namespace: str, number: int, kind: int, stamp: Any, color: Sequence[float], opacity: float
) -> Marker:
    marker = Marker(ns=namespace, id=number, type=kind, action=Marker.ADD)
    marker.header.frame_id, marker.header.stamp = FRAME, stamp
    marker.color = ColorRGBA(**dict(zip("rgba", (*color, opacity), strict=True)))
    return marker
