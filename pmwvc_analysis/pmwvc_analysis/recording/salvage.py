# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The messages of an MCAP file from front to back, as far as the file is whole, and a new session
folder made of them.

A killed recorder leaves a file without index and footer, often cut in the middle of a record.
Everything up to the last whole chunk is there, each chunk guarded by its checksum.
"""

import shutil
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap import records as mcap
from mcap.exceptions import EndOfFile, McapError
from mcap.stream_reader import CRCValidationError, StreamReader
from zstandard import ZstdError

from pmwvc_analysis.recording.format.topics import Topic
from pmwvc_analysis.recording.writer import SessionWriter
from pmwvc_core.errors import RecordingError, file_errors

# What the library raises where a file is damaged.
DAMAGE = (McapError, CRCValidationError, ZstdError, struct.error, ValueError, RuntimeError)
WHOLE = "file was whole"
COMPANIONS = ("scenario.yaml", "events.json", "nodes")


class RawMessage(NamedTuple):
    """One serialized message with its channel and times [ns]."""

    topic: str
    type_name: str
    log_ns: int
    publish_ns: int
    data: bytes


@dataclass
class Salvage:
    """Everything else in the file, filled while its messages are iterated."""

    schemas: dict[str, str] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    topics: dict[str, None] = field(default_factory=dict)
    messages: int = 0
    end: str | None = None  # why the file ends early; None: it is complete


def messages(path: str | Path, salvage: Salvage) -> Iterator[RawMessage]:
    """Yield every message of every whole chunk; ``salvage`` holds how far the file was good.
    RecordingError where it cannot be opened.
    """
    with file_errors(f"read {path}"):
        stream = open(path, "rb")
    channels: dict[int, mcap.Channel] = {}
    names: dict[int, str] = {}
    with stream:
        try:
            for record in StreamReader(stream, validate_crcs=True).records:
                match record:
                    case mcap.Schema(id=number, name=name, data=text):
                        names[number] = name
                        salvage.schemas[name] = text.decode("utf-8", "replace")
                    case mcap.Channel():
                        channels[record.id] = record
                        salvage.topics[record.topic] = None
                    case mcap.Metadata():
                        salvage.metadata[record.name] = record.metadata
                    case mcap.Message(log_time=log_ns, publish_time=publish_ns, data=data):
                        if (channel := channels.get(record.channel_id)) is not None:
                            salvage.messages += 1
                            name = names.get(channel.schema_id, "")
                            yield RawMessage(channel.topic, name, log_ns, publish_ns, data)
        except DAMAGE as error:
            salvage.end = damage(error, stream)


def damage(error: Exception, stream: BinaryIO) -> str:
    """Return in words why a file ends early, and where."""
    cut = isinstance(error, (EndOfFile, struct.error))
    reason = "cut in the middle of a record" if cut else str(error) or type(error).__name__
    return f"{reason}, at byte {stream.tell()}"


def recover(damaged: str | Path, target_folder: str | Path) -> Salvage:
    """Write what is whole in a damaged ``.mcap`` file as a new, complete session folder.

    The damaged file is left as it is. Topics keep their names, types, times and bytes.
    RecordingError where nothing can be read or written, or the new file does not read back whole.
    """
    salvage, again = Salvage(), Salvage()
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
        cut = salvage.end or WHOLE
        writer.add_metadata("recovered", {"from": Path(damaged).name, "cut": cut})
    count = sum(1 for _ in messages(writer.path, again))
    if writer.problem or again.end or count != salvage.messages:
        why = writer.problem or again.end or "the new file is incomplete"
        read = f"{count} of {salvage.messages} messages read back"
        raise RecordingError(f"recovery of {damaged} failed: {read}; {why}")
    return salvage


def mend(folder: str | Path, target: str | Path) -> str:
    """Recover a session folder (or one file) into a new one; return as text what was kept.

    Scenario, events and logs are copied. RecordingError where it holds not exactly one MCAP file,
    or the file cannot be recovered.
    """
    source, new = Path(folder), Path(target)
    files = sorted(source.glob("*.mcap")) if source.is_dir() else [source]
    if len(files) != 1:
        raise RecordingError(f"{source} holds {len(files)} .mcap files: name the one to mend")
    if new.exists() and (not new.is_dir() or any(new.iterdir())):
        raise RecordingError(f"{new} is not empty: a mended session needs a folder of its own")
    salvage = recover(files[0], new)
    with file_errors(f"write into {new}"):
        for name in COMPANIONS if source.is_dir() else ():
            if (source / name).is_dir():
                shutil.copytree(source / name, new / name)
            elif (source / name).is_file():
                shutil.copy2(source / name, new / name)
    why = salvage.end or "the file was whole"
    return f"{salvage.messages} messages of {files[0]} are in {new} ({why})"
