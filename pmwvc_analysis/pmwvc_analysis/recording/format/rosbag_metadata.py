# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The metadata of a recording: the ``metadata.yaml`` that makes a folder a rosbag2 recording
(version 9), and MCAP records of names and texts: source, scenario, seed, parameters, versions.
"""

import os
import platform
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path

from pmwvc_analysis.recording.format.topics import Topic
from pmwvc_core.scenario.scenario import Scenario

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


def write(folder: Path, content: Mapping[str, object]) -> None:
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
