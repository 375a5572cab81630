# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The writer of a session folder: ``session.mcap`` and ``metadata.yaml``.

Chunks are compressed with zstd, end at 4 MiB or after one second, and carry a checksum; so does
the whole data section. What a killed process leaves is readable up to its last whole chunk
(salvage.py). When the disk is full or not writable, writing stops for good: the file is cut back
to the last full second, the reason is kept in ``problem`` and everything offered afterwards is
counted in ``refused``. Nothing here raises then: a recorder must not bring down a session.
"""

import contextlib
import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import BinaryIO

from mcap.writer import CompressionType, Writer

from pmwvc_analysis.recording import schemas, topics
from pmwvc_analysis.recording.topics import Topic
from pmwvc_core.errors import RecordingError, file_errors

FILE_NAME = "session.mcap"
LIBRARY = "pmwvc"
CHUNK_BYTES = 4 * 1024 * 1024
CHUNK_NS = 1_000_000_000
RESERVE_BYTES = 64 * 1024 * 1024


class SessionWriter(contextlib.AbstractContextManager["SessionWriter"]):
    """Writes serialized messages into a session folder, which is created where it does not exist;
    RecordingError where it cannot be written, holds a recording, or its disk is too full.

    Writing stops in good order at ``reserve_bytes`` of free space, before the disk is full.
    """

    def __init__(self, folder: str | Path, *, reserve_bytes: int = RESERVE_BYTES) -> None:
        self.folder = Path(folder)
        self.path = self.folder / FILE_NAME
        self.problem: str | None = None
        self.refused = 0
        self.messages: dict[str, int] = {}  # per topic
        self._span_ns: tuple[int, int] | None = None
        self._reserve = reserve_bytes
        self._channels: dict[str, tuple[int, Topic]] = {}
        self._types: dict[str, tuple[int, str]] = {}  # schema and hash by name
        self._since_ns: int | None = None  # first log time after the last flush
        self._kept: dict[str, int] = {}  # messages per topic up to there
        self._closed = False
        with file_errors(f"record into {self.folder}"):
            self.folder.mkdir(parents=True, exist_ok=True)
            if (full := self._too_full()) is not None:
                remedy = "make room or choose another folder"
                raise RecordingError(f"cannot record into {self.folder}: {full}; {remedy}")
            try:
                self._file: BinaryIO = open(self.path, "xb")
            except FileExistsError as error:
                never = "a recording is never overwritten; choose another folder"
                raise RecordingError(f"{self.path} exists: {never}") from error
        options = {"compression": CompressionType.ZSTD, "enable_data_crcs": True}
        self._writer = Writer(self._file, CHUNK_BYTES, **options)
        self._good = 0
        self._guarded(lambda: self._writer.start(profile="ros2", library=LIBRARY))
        self._guarded(self._end_chunk)

    def _end_chunk(self) -> None:
        self._writer.flush()
        self._good = self._file.tell()

    def __exit__(self, *_: object) -> None:
        self.close()

    def add_topic(self, topic: Topic) -> None:
        """Announce a topic."""
        if (name := topic.type_name) not in self._types:
            text = schemas.schema_text(name)
            number = self._writer.register_schema(name, "ros2msg", text.encode())
            self._types[name] = number, schemas.store_of((text, name)).hash_rihs01(name)
        qos, (schema_id, type_hash) = topics.dump(topic.qos), self._types[name]
        metadata = {"offered_qos_profiles": qos.strip(), "topic_type_hash": type_hash}
        channel = self._writer.register_channel(topic.name, "cdr", schema_id, metadata)
        self._channels[topic.name] = (channel, topic)
        self.messages[topic.name] = 0

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write a record of names and texts: parameters, seeds, versions."""
        if not self.problem:
            self._guarded(lambda: self._writer.add_metadata(name, dict(values)))

    def write(
        self, topic: str, data: bytes, *, log_ns: int, publish_ns: int | None = None
    ) -> None:
        """Add a serialized message (CDR) to an announced topic."""
        if self._since_ns is not None and abs(log_ns - self._since_ns) >= CHUNK_NS:
            self.flush()
        if self.problem or self._closed:
            self.refused += 1
            return
        if self._since_ns is None:
            self._since_ns = log_ns
        channel, _ = self._channels[topic]
        self.messages[topic] += 1
        number = self.messages[topic] & 0xFFFFFFFF
        first_ns, last_ns = self._span_ns or (log_ns, log_ns)
        self._span_ns = min(first_ns, log_ns), max(last_ns, log_ns)
        sent_ns = log_ns if publish_ns is None else publish_ns
        self._guarded(lambda: self._writer.add_message(channel, log_ns, data, sent_ns, number))

    def flush(self) -> None:
        """End the chunk and hand it to the system; stop in good order when space runs out."""
        if self.problem or self._closed:
            return
        self._guarded(self._end_chunk)
        self._since_ns = None
        if self.problem:
            return
        self._kept = dict(self.messages)
        if (full := self._too_full()) is not None:
            self._finish()
            self.problem = f"recording stopped: {full}; everything up to here is kept"

    def refresh_metadata(self) -> None:
        """Write ``metadata.yaml`` for what is recorded so far."""
        with contextlib.suppress(OSError):  # a full disk keeps the older, still valid one
            topics.write_metadata(self.folder, self._information())

    def close(self) -> None:
        """Write index, summary and final ``metadata.yaml``; harmless when called again."""
        if self._closed:
            return
        self.flush()
        if not self.problem:
            self._finish()
        self._closed = True
        with contextlib.suppress(OSError, ValueError):
            self._file.close()
        self.refresh_metadata()

    def _finish(self) -> None:
        """Write everything that completes the MCAP file."""
        self.add_metadata("rosbag2", {"serialized_metadata": topics.dump(self._information())})
        self._guarded(self._writer.finish)
        self._guarded(self._file.flush)

    def _too_full(self) -> str | None:
        """Return in words that the disk has less space than is kept free."""
        with contextlib.suppress(OSError):
            if (free := shutil.disk_usage(self.folder).free) < self._reserve:
                kept = f"{self._reserve >> 20} MiB are kept free"
                return f"{free >> 20} MiB left on the disk, {kept}"
        return None

    def _information(self) -> dict[str, object]:
        counts = [
            (topic, self._types[topic.type_name][1], self._kept.get(name, 0))
            for name, (_, topic) in self._channels.items()
        ]
        start_ns, end_ns = self._span_ns or (0, 0)
        return topics.information(counts, file_name=FILE_NAME, start_ns=start_ns, end_ns=end_ns)

    def _guarded(self, action: Callable[[], object]) -> None:
        """Do something with the file; the first failure ends the recording."""
        if self.problem:
            return
        try:
            action()
        except OSError as error:
            self.problem = (
                f"recording stopped: {error.strerror or error}; "
                f"kept up to the last full second ({self._good} bytes)"
            )
            self.refused += sum(self.messages.values()) - sum(self._kept.values())
            # drop what is behind the last full second, past the half-written buffer
            raw = getattr(self._file, "raw", None) or self._file
            with contextlib.suppress(OSError, ValueError):
                os.ftruncate(raw.fileno(), self._good)
                raw.close()
