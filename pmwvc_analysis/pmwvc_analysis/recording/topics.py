# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The topics of a session from the names of users and links, and the metadata of a recording: the
``metadata.yaml`` that makes a folder a rosbag2 recording (version 9), and MCAP records of names
and texts: source, scenario, seed, parameters, versions.
"""

import contextlib
import json
import os
import platform
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import yaml

from pmwvc_analysis.recording import schemas
from pmwvc_core.runtime.messages import KEPT, record_of
from pmwvc_core.scenario.scenario import Scenario

PACKAGES = ("pmwvc", "pmwvc_core", "rclpy", "numpy", "scipy", "mcap", "rosbags")
HAND = {schemas.POSE: "hand/target", schemas.FLAG: "hand/held"}  # of a remote one
SCENE = "/server/scene"  # description of the environment, where it has one
ENDLESS = {"sec": 9223372036, "nsec": 854775807}


class Topic(NamedTuple):
    """One recorded topic; ``depth`` is the publisher's, ``essential`` ones are waited for."""

    name: str
    type_name: str
    reliable: bool = True
    depth: int = KEPT
    essential: bool = True
    latched: bool = False  # published once, kept for those who come later

    @property
    def source(self) -> str:
        """The ROS topic that it is recorded from."""
        return record_of(self.name) if self.type_name in (schemas.WAVE, *HAND) else self.name

    @property
    def qos(self) -> list[dict[str, object]]:
        """The offered profiles the way rosbag2 (metadata version 9) writes them."""
        profile = {
            "history": "keep_last",
            "depth": self.depth,
            "reliability": "reliable" if self.reliable else "best_effort",
            "durability": "transient_local" if self.latched else "volatile",
            "deadline": ENDLESS,
            "lifespan": ENDLESS,
            "liveliness": "automatic",
            "liveliness_lease_duration": ENDLESS,
            "avoid_ros_namespace_conventions": False,
        }
        return [profile]


def session_topics(
    users: Sequence[str], *, links: Sequence[str], people: bool = False
) -> list[Topic]:
    """Return every topic of a session with these users, whose names are their namespaces.

    ``links`` are the emulated ones (``user1/up``): a direction without has one topic instead of
    two, as both sides are joined by remapping onto the master's. With ``people`` also what is made
    for people or by them (markers, diagnostics, the targets of their hands).
    """
    found = [Topic("/server/trace", schemas.SERVER_TRACE)]
    for user in users:
        names = [f"/{user}/wave_up", f"/{user}/wave_down"]
        names += [f"/server/{user}/wave_{w}" for w in ("up", "down") if f"{user}/{w}" in links]
        found += [Topic(name, schemas.WAVE) for name in names]
        found.append(Topic(f"/{user}/trace", schemas.MASTER_TRACE))
    if links:
        found.append(Topic("/netem/fates", schemas.PACKET_FATE))
    found.append(Topic(SCENE, schemas.TEXT, depth=1, essential=False, latched=True))
    for node in ("server", *users):
        found.append(Topic(f"/{node}/reception", schemas.RECEPTION, essential=False))
    found.append(Topic("/parameter_events", schemas.PARAMETER_EVENT, depth=1000, essential=False))
    if people:
        for user in users:
            found += [Topic(f"/{user}/{end}", kind, essential=False) for kind, end in HAND.items()]
        found.append(Topic("/markers", schemas.MARKERS, depth=10, essential=False))
        found.append(Topic("/diagnostics", schemas.DIAGNOSTICS, depth=10, essential=False))
    return found


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
        "message_count": sum(messages for _, _, messages in topics),
    }
    listed = [
        {
            "topic_metadata": {
                "name": topic.name,
                "type": topic.type_name,
                "serialization_format": "cdr",
                "offered_qos_profiles": topic.qos,
                "type_description_hash": type_hash,
            },
            "message_count": messages,
        }
        for topic, type_hash, messages in topics
    ]
    return {
        "version": 9,
        "storage_identifier": "mcap",
        **span,
        "topics_with_message_count": listed,
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file_name],
        "files": [{"path": file_name, **span}],
        "custom_data": None,
        "ros_distro": "jazzy",
    }


def dump(content: object) -> str:
    """Return YAML in block style, without aliases."""
    once = json.loads(json.dumps(content))
    text: str = yaml.safe_dump(once, sort_keys=False, allow_unicode=True)
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
