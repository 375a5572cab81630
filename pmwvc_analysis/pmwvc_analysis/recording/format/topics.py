# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The topics of a session from the names of users and links, and the metadata of a recording: the
``metadata.yaml`` that makes a folder a rosbag2 recording (version 9), and MCAP records of names
and texts: source, scenario, seed, parameters, versions.
"""

import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from pmwvc_analysis.recording.format import schemas
from pmwvc_core.runtime.messages import KEPT, record_of
from pmwvc_core.scenario.scenario import Scenario


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


VERSION = 9


def information(
    topics: Sequence[tuple[Topic, str, int]], *, file_name: str, start_ns: int, end_ns: int
) -> dict[str, object]:
    """Return the content of ``metadata.yaml`` from topics, type hashes and message counts."""
    start = {"nanoseconds_since_epoch": start_ns}
    duration = {"nanoseconds": max(0, end_ns - start_ns)}
    count = sum(messages for _, _, messages in topics)
    return {
        "version": VERSION,
        "storage_identifier": "mcap",
        "duration": dict(duration),
        "starting_time": dict(start),
        "message_count": count,
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.type_name,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [topic.qos()],
                    "type_description_hash": type_hash,
                },
                "message_count": messages,
            }
            for topic, type_hash, messages in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file_name],
        "files": [
            {
                "path": file_name,
                "starting_time": start,
                "duration": duration,
                "message_count": count,
            }
        ],
        "custom_data": None,
        "ros_distro": "jazzy",
    }


def dump(content: object) -> str:
    """Return YAML in block style."""
    import yaml

    text: str = yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
    return text


def write_metadata(folder: Path, content: Mapping[str, object]) -> None:
    """Replace the folder's ``metadata.yaml`` in one step: a reader never sees half of it."""
    target = folder / "metadata.yaml"
    temporary = folder / ".metadata.yaml.tmp"
    try:
        temporary.write_text(dump({"rosbag2_bagfile_information": content}), encoding="utf-8")
        os.replace(temporary, target)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


PACKAGES = ("pmwvc", "pmwvc_core", "rclpy", "numpy", "scipy", "mcap", "rosbags")


def about(scenario: Scenario | None, *, source: str) -> dict[str, dict[str, str]]:
    """Return the metadata records of a session by name."""
    session = {"source": source}
    records = {"session": session, "software": versions()}
    if scenario is not None:
        session |= {"scenario": scenario.name, "seed": str(scenario.seed)}
        records["parameters"] = {
            name: "null" if value is None else str(value)
            for name, value in scenario.flat().items()
        }
    return records


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that matter and are there."""
    found = {"python": platform.python_version(), "system": platform.platform()}
    for package in PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return found
