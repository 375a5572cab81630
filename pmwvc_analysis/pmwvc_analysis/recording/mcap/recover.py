# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading an MCAP file from front to back, as far as it is whole, and writing that part anew.

A killed recorder leaves a file without index and footer, often cut in the middle of a record.
Everything up to the last whole chunk is there, each chunk guarded by its checksum.
"""

import shutil
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pmwvc_core.errors import RecordingError

COMPANIONS = ("scenario.yaml", "events.json", "nodes")


@dataclass(frozen=True)
class RawMessage:
    """One serialized message with its times and channel."""

    topic: str
    type_name: str
    log_ns: int
    publish_ns: int
    data: bytes


@dataclass
class Salvage:
    """What reading found on its way: filled while the messages are iterated."""

    schemas: dict[str, str] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    messages: int = 0
    end: str | None = None  # why the file ends early; None: it is complete


def messages(path: str | Path, salvage: Salvage) -> Iterator[RawMessage]:
    """Yield every message of every whole chunk; ``salvage`` tells how far the file was good.

    Raises
    ------
    RecordingError
        If the file cannot be opened.
    """
    from mcap.exceptions import EndOfFile, McapError
    from mcap.stream_reader import CRCValidationError, StreamReader
    from zstandard import ZstdError

    try:
        stream = open(path, "rb")
    except OSError as error:
        raise RecordingError(f"cannot read {path}: {error.strerror or error}") from error
    channels: dict[int, Any] = {}
    names: dict[int, str] = {}
    with stream:
        try:
            for record in StreamReader(stream, validate_crcs=True).records:
                kind = type(record).__name__
                if kind == "Schema":
                    names[record.id] = record.name
                    salvage.schemas[record.name] = record.data.decode("utf-8", "replace")
                elif kind == "Channel":
                    channels[record.id] = record
                elif kind == "Metadata":
                    salvage.metadata[record.name] = dict(record.metadata)
                elif kind == "Message" and record.channel_id in channels:
                    channel = channels[record.channel_id]
                    salvage.messages += 1
                    yield RawMessage(
                        channel.topic,
                        names.get(channel.schema_id, ""),
                        record.log_time,
                        record.publish_time,
                        record.data,
                    )
        except (McapError, CRCValidationError, ZstdError, struct.error, ValueError) as error:
            cut = isinstance(error, (EndOfFile, struct.error))
            reason = "cut in the middle of a record" if cut else str(error) or type(error).__name__
            salvage.end = f"{reason}, at byte {stream.tell()}"


def recover(damaged: str | Path, target_folder: str | Path) -> Salvage:
    """Write what is whole in a damaged ``.mcap`` file as a new, complete session folder.

    The damaged file is left as it is. Topics keep their names, types, times and bytes.

    Raises
    ------
    RecordingError
        If nothing can be read or written, or the new file does not read back whole.
    """
    from pmwvc_analysis.recording.topics import Topic
    from pmwvc_analysis.recording.writer import SessionWriter

    salvage = Salvage()
    with SessionWriter(target_folder) as writer:
        for message in messages(damaged, salvage):
            writer.add_topic(
                Topic(message.topic, message.type_name, reliable=True, depth=10),
                schema=salvage.schemas[message.type_name],
            )
            writer.write(
                message.topic, message.data, log_ns=message.log_ns, publish_ns=message.publish_ns
            )
        for name, values in salvage.metadata.items():
            if name != "rosbag2":
                writer.add_metadata(name, values)
        writer.add_metadata(
            "recovered", {"from": Path(damaged).name, "cut": salvage.end or "file was whole"}
        )
    again = Salvage()
    count = sum(1 for _ in messages(writer.path, again))
    if writer.problem or again.end or count != salvage.messages:
        raise RecordingError(
            f"recovery of {damaged} failed: {count} of {salvage.messages} messages read back; "
            f"{writer.problem or again.end or 'the new file is incomplete'}"
        )
    return salvage


def mend(folder: str | Path, target: str | Path) -> str:
    """Recover a session folder (or one file) into a new one; return in words what was kept.

    Scenario, events and logs are copied.

    Raises
    ------
    RecordingError
        If it holds not exactly one MCAP file, or the file cannot be recovered.
    """
    source, new = Path(folder), Path(target)
    files = sorted(source.glob("*.mcap")) if source.is_dir() else [source]
    if len(files) != 1:
        raise RecordingError(f"{source} holds {len(files)} .mcap files: name the one to mend")
    if new.exists() and (not new.is_dir() or any(new.iterdir())):
        raise RecordingError(f"{new} is not empty: a mended session needs a folder of its own")
    salvage = recover(files[0], new)
    try:
        for name in COMPANIONS if source.is_dir() else ():
            if (source / name).is_dir():
                shutil.copytree(source / name, new / name)
            elif (source / name).is_file():
                shutil.copy2(source / name, new / name)
    except OSError as error:
        raise RecordingError(f"cannot write into {new}: {error.strerror or error}") from error
    why = salvage.end or "the file was whole"
    return f"{salvage.messages} messages of {files[0]} are in {new} ({why})"
