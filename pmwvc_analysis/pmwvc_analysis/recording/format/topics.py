# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The topics of a session from the names of users and links: name, type, quality of service."""

from collections.abc import Sequence
from dataclasses import dataclass

from pmwvc_analysis.recording.format import schemas
from pmwvc_core.runtime.records import KEPT, record_of


@dataclass(frozen=True)
class Topic:
    """One recorded topic; ``depth`` is the publisher's, ``essential`` ones are waited for."""

    name: str
    type_name: str
    reliable: bool
    depth: int
    essential: bool = True

    @property
    def source(self) -> str:
        """The ROS topic that it is recorded from."""
        return record_of(self.name) if self.type_name == schemas.WAVE else self.name

    def qos(self) -> dict[str, object]:
        """Return the offered profile the way rosbag2 (metadata version 9) writes it."""
        endless = {"sec": 9223372036, "nsec": 854775807}
        return {
            "history": "keep_last",
            "depth": self.depth,
            "reliability": "reliable" if self.reliable else "best_effort",
            "durability": "volatile",
            "deadline": dict(endless),
            "lifespan": dict(endless),
            "liveliness": "automatic",
            "liveliness_lease_duration": dict(endless),
            "avoid_ros_namespace_conventions": False,
        }


def wave(name: str) -> Topic:
    """Return a topic that carries waves."""
    return Topic(name, schemas.WAVE, reliable=True, depth=KEPT)


def trace(name: str, type_name: str) -> Topic:
    """Return a topic that carries records for the analysis."""
    return Topic(name, type_name, reliable=True, depth=KEPT)


def reception(node: str) -> Topic:
    """Return the topic on which a user's master, or the server, reports what it has received."""
    return Topic(f"/{node}/reception", schemas.RECEPTION, True, KEPT, essential=False)


def session_topics(
    users: Sequence[str], *, links: Sequence[str], people: bool = False
) -> list[Topic]:
    """Return every topic of a session with these users, whose names are their namespaces.

    Parameters
    ----------
    links
        Names of the emulated links (``user1/up``). A direction without a link has one topic
        instead of two: the two sides are joined by remapping onto the master's topic.
    people
        Also what is made for people or by them (markers, diagnostics, the targets of their
        hands); nothing waits for these.
    """
    found = []
    for user in users:
        found += [wave(f"/{user}/wave_up"), wave(f"/{user}/wave_down")]
        found += [
            wave(f"/server/{user}/wave_{way}")
            for way in ("up", "down")
            if f"{user}/{way}" in links
        ]
        found.append(trace(f"/{user}/trace", schemas.MASTER_TRACE))
        found.append(reception(user))
    found += [trace("/server/trace", schemas.SERVER_TRACE), reception("server")]
    if links:
        found.append(trace("/netem/links", schemas.LINK_STATE))
        found.append(trace("/netem/fates", schemas.PACKET_FATE))
    found.append(Topic("/parameter_events", schemas.PARAMETER_EVENT, True, 1000, essential=False))
    if people:
        for user in users:
            found += [
                Topic(f"/{user}/hand/target", schemas.POINT, False, 4, essential=False),
                Topic(f"/{user}/hand/held", schemas.FLAG, True, 4, essential=False),
            ]
        found.append(
            Topic("/markers", "visualization_msgs/msg/MarkerArray", True, 10, essential=False)
        )
        found.append(
            Topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", True, 10, essential=False)
        )
    return found


def relayed(topic: str) -> tuple[str, str] | None:
    """Return the link that a topic comes out of, and the topic that feeds it.

    ``/server/user1/wave_up`` comes out of ``user1/up``, fed by ``/user1/wave_up``;
    ``/user1/wave_down`` out of ``user1/down``, fed by ``/server/user1/wave_down``.
    """
    parts = topic.strip("/").split("/")
    if len(parts) == 3 and parts[0] == "server" and parts[2] == "wave_up":
        return f"{parts[1]}/up", f"/{parts[1]}/wave_up"
    if len(parts) == 2 and parts[1] == "wave_down":
        return f"{parts[0]}/down", f"/server/{parts[0]}/wave_down"
    return None


def source_of(link: str) -> str:
    """Return the topic that feeds a link."""
    user, _, direction = link.rpartition("/")
    return f"/{user}/wave_up" if direction == "up" else f"/server/{user}/wave_down"
