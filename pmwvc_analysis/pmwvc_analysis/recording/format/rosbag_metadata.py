# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The ``metadata.yaml`` that makes a folder a rosbag2 recording (version 9)."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

VERSION = 9


@dataclass(frozen=True)
class TopicCount:
    """One topic of a recording and how many messages it has."""

    name: str
    type_name: str
    type_hash: str
    qos: Mapping[str, object] | None
    messages: int


def information(
    topics: Sequence[TopicCount],
    *,
    file_name: str,
    start_ns: int,
    end_ns: int,
    custom: Mapping[str, str],
) -> dict[str, Any]:
    """Return the content below ``rosbag2_bagfile_information``."""
    count = sum(topic.messages for topic in topics)
    duration = max(0, end_ns - start_ns)
    return {
        "version": VERSION,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": duration},
        "starting_time": {"nanoseconds_since_epoch": start_ns},
        "message_count": count,
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.type_name,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [dict(topic.qos)] if topic.qos else [],
                    "type_description_hash": topic.type_hash,
                },
                "message_count": topic.messages,
            }
            for topic in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file_name],
        "files": [
            {
                "path": file_name,
                "starting_time": {"nanoseconds_since_epoch": start_ns},
                "duration": {"nanoseconds": duration},
                "message_count": count,
            }
        ],
        "custom_data": dict(custom) or None,
        "ros_distro": "jazzy",
    }


def dump(content: Any) -> str:
    """Return YAML in block style."""
    import yaml

    text: str = yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
    return text


def write(folder: Path, content: Mapping[str, Any]) -> None:
    """Replace the folder's ``metadata.yaml`` in one step: a reader never sees half of it."""
    target = folder / "metadata.yaml"
    temporary = folder / ".metadata.yaml.tmp"
    try:
        temporary.write_text(dump({"rosbag2_bagfile_information": content}), encoding="utf-8")
        os.replace(temporary, target)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
