# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The messages of an MCAP file from front to back, as far as the file is whole.

A killed recorder leaves a file without index and footer, often cut in the middle of a record.
Everything up to the last whole chunk is there, each chunk guarded by its checksum.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from pmwvc_core.errors import file_errors


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
    from mcap import records as mcap
    from mcap.exceptions import EndOfFile, McapError
    from mcap.stream_reader import CRCValidationError, StreamReader
    from zstandard import ZstdError

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
        except (McapError, CRCValidationError, ZstdError, struct.error, ValueError) as error:
            cut = isinstance(error, (EndOfFile, struct.error))
            reason = "cut in the middle of a record" if cut else str(error) or type(error).__name__
            salvage.end = f"{reason}, at byte {stream.tell()}"
