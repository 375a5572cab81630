# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Writing beside receiving: a bounded queue and a thread that empties it into a session folder.

Whoever receives never waits for the disk. What the queue cannot hold is counted per topic, and
shows in the publishers' numbers as well; the final record ``losses`` names both.
"""

import queue
import threading
import time
from collections import Counter
from typing import NamedTuple

from pmwvc_analysis.recording.writer import SessionWriter

QUEUE_MESSAGES = 50_000  # tens of seconds of a session of two users
FLUSH_S = 1.0


class Received(NamedTuple):
    """A serialized message with its times [ns]."""

    topic: str
    data: bytes
    log_ns: int
    publish_ns: int


class BackgroundWriter:
    """Hands messages to a :class:`SessionWriter` in a thread of its own.

    Parameters
    ----------
    writer
        Where to; only that thread touches it until :meth:`close` returns.
    capacity
        Messages that may wait.
    """

    def __init__(self, writer: SessionWriter, *, capacity: int = QUEUE_MESSAGES) -> None:
        self.writer = writer
        self.overrun: Counter[str] = Counter()
        self._queue: queue.Queue[Received | None] = queue.Queue(capacity)
        self._thread = threading.Thread(target=self._run, name="writer")
        self._thread.start()

    def put(self, message: Received) -> None:
        """Take a message; never waits."""
        try:
            self._queue.put_nowait(message)
        except queue.Full:
            self.overrun[message.topic] += 1

    @property
    def problem(self) -> str | None:
        """Why nothing is written any more, or None."""
        return self.writer.problem

    def close(self) -> list[str]:
        """Write what waits, complete the recording, and return the losses in words."""
        if self._thread.is_alive():
            self._queue.put(None)
            self._thread.join()
            self.writer.add_metadata("losses", self._losses())
            self.writer.close()
        return self.report()

    def report(self) -> list[str]:
        """Return what is missing in the recording and why, one line each."""
        found = [
            f"{topic}: {count} did not fit the queue" for topic, count in self.overrun.items()
        ]
        if self.writer.problem:
            found.append(f"{self.writer.problem}; {self.writer.refused} messages not written")
        return found + self.writer.counter.lines()

    def _losses(self) -> dict[str, str]:
        counter = self.writer.counter
        return {
            topic: f"{counter.messages[topic]} messages, "
            f"{counter.missing(topic)} numbers missing, "
            f"{self.overrun[topic]} not queued"
            for topic in counter.messages
        }

    def _run(self) -> None:
        flush_at = time.monotonic()
        while True:
            if time.monotonic() >= flush_at:
                flush_at += FLUSH_S
                self.writer.flush()
                self.writer.refresh_metadata()
            try:
                message = self._queue.get(timeout=max(flush_at - time.monotonic(), 0.0))
            except queue.Empty:
                continue
            if message is None:
                return
            self.writer.write(
                message.topic,
                message.data,
                log_ns=message.log_ns,
                publish_ns=message.publish_ns,
            )
