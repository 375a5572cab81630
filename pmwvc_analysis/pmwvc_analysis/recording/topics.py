# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The topics of a session from the names of users and links, and the metadata of a recording: the
``metadata.yaml`` that makes a folder a rosbag2 recording (version 9), and MCAP records of names
and texts: source, scenario, seed, parameters, versions. And the space that a recording takes.
"""

import contextlib
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from pmwvc_analysis.recording import schemas
from pmwvc_core.runtime.messages import KEPT, record_of
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.transport.packet import size_bytes

PACKAGES = ("pmwvc", "pmwvc_core", "rclpy", "numpy", "scipy", "mcap", "rosbags")
COMPRESSED = 0.45  # of the bytes: measured over live sessions of two users
RECORD_BYTES = 47  # around a message: its record and its entry in the index


@dataclass(frozen=True)
class Topic:
    """One recorded topic; ``depth`` is the publisher's, ``essential`` ones are waited for."""

    name: str
    type_name: str
    reliable: bool = True
    depth: int = KEPT
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


def session_topics(
    users: Sequence[str], *, links: Sequence[str], people: bool = False
) -> list[Topic]:
    """Return every topic of a session with these users, whose names are their namespaces.

    ``links`` are the emulated ones (``user1/up``): a direction without has one topic instead of
    two, as both sides are joined by remapping onto the master's. With ``people`` also what is made
    for people or by them (markers, diagnostics, the targets of their hands).
    """
    found = []
    for user in users:
        names = [f"/{user}/wave_up", f"/{user}/wave_down"]
        ends = [f"/server/{user}/wave_{w}" for w in ("up", "down") if f"{user}/{w}" in links]
        found += [Topic(name, schemas.WAVE) for name in names + ends]
        found.append(Topic(f"/{user}/trace", schemas.MASTER_TRACE))
        found.append(Topic(f"/{user}/reception", schemas.RECEPTION, essential=False))
    found.append(Topic("/server/trace", schemas.SERVER_TRACE))
    found.append(Topic("/server/reception", schemas.RECEPTION, essential=False))
    if links:
        found.append(Topic("/netem/links", schemas.LINK_STATE))
        found.append(Topic("/netem/fates", schemas.PACKET_FATE))
    quiet = [("/parameter_events", schemas.PARAMETER_EVENT, True, 1000)]
    if people:
        for user in users:
            quiet.append((f"/{user}/hand/target", schemas.POINT, False, 4))
            quiet.append((f"/{user}/hand/held", schemas.FLAG, True, 4))
        quiet.append(("/markers", "visualization_msgs/msg/MarkerArray", True, 10))
        quiet.append(("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", True, 10))
    return found + [Topic(*each, essential=False) for each in quiet]


def relayed(topic: str) -> str | None:
    """Return the link that a topic comes out of: ``/server/user1/wave_up`` comes out of
    ``user1/up``, ``/user1/wave_down`` out of ``user1/down``.
    """
    match topic.strip("/").split("/"):
        case ["server", user, "wave_up"]:
            return f"{user}/up"
        case [user, "wave_down"]:
            return f"{user}/down"
    return None


def source_of(link: str) -> str:
    """Return the topic that feeds a link."""
    user, _, direction = link.rpartition("/")
    return f"/{user}/wave_up" if direction == "up" else f"/server/{user}/wave_down"


def information(
    topics: Sequence[tuple[Topic, str, int]], *, file_name: str, start_ns: int, end_ns: int
) -> dict[str, object]:
    """Return the content of ``metadata.yaml`` from topics, type hashes and message counts."""
    span = {
        "duration": {"nanoseconds": max(0, end_ns - start_ns)},
        "starting_time": {"nanoseconds_since_epoch": start_ns},
    }
    count = sum(messages for _, _, messages in topics)
    return {
        "version": 9,
        "storage_identifier": "mcap",
        **{key: dict(value) for key, value in span.items()},
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
        "files": [{"path": file_name, **span, "message_count": count}],
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
    target, temporary = folder / "metadata.yaml", folder / ".metadata.yaml.tmp"
    try:
        temporary.write_text(dump({"rosbag2_bagfile_information": content}), encoding="utf-8")
        os.replace(temporary, target)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


def about(scenario: Scenario | None, *, source: str) -> dict[str, dict[str, str]]:
    """Return the metadata records of a session by name; ``software`` are the versions of Python
    and of the packages that matter and are there.
    """
    software = {"python": platform.python_version(), "system": platform.platform()}
    for package in PACKAGES:
        with contextlib.suppress(metadata.PackageNotFoundError):
            software[package] = metadata.version(package)
    session = {"source": source}
    if scenario is None:
        return {"session": session, "software": software}
    session |= {"scenario": scenario.name, "seed": str(scenario.seed)}
    flat = scenario.flat().items()
    parameters = {name: "null" if value is None else str(value) for name, value in flat}
    return {"session": session, "software": software, "parameters": parameters}


def bytes_per_message(scenario: Scenario, user: User) -> tuple[float, float, float]:
    """Return what a block of ticks of a user's master, a step of the server and a packet take in
    the file before compression [byte].
    """
    dof = scenario.dof
    block = 212 + user.master.rate_drop * (64 * dof + 8)
    step = 184 + 24 * dof + len(scenario.users) * (40 * dof + 30)
    return block + RECORD_BYTES, step + RECORD_BYTES, size_bytes(dof) + RECORD_BYTES


def live_bytes_per_minute(scenario: Scenario) -> float:
    """Return what the recording of a live session takes on disk a minute [byte]."""
    health = 1000 + RECORD_BYTES  # diagnostics of one node, once a second
    link = 4 * (196 + RECORD_BYTES) + 10 * (60 + RECORD_BYTES)  # states, heads of fate blocks
    steps_hz = 1.0 / scenario.server.period_s
    _, step, packet = bytes_per_message(scenario, scenario.users[0])
    raw = steps_hz * step + 31 * (1500 + RECORD_BYTES) + 3 * health  # and markers
    for user in scenario.users:
        frames_hz = 1.0 / user.master.frame_s
        raw += frames_hz * bytes_per_message(scenario, user)[0] + 2 * link + health
        raw += (frames_hz + steps_hz) * (2 * packet + 42)  # at either end of a link, and its fate
    return 60.0 * COMPRESSED * raw
