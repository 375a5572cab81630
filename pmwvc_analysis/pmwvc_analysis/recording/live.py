# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The bounded queue of received messages and the thread that writes them into a session folder.

The receiver never waits for the disk. Messages that the queue cannot hold are counted per topic,
and their numbers are missing as well; the final record ``losses`` names both.
"""

import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Sequence

from pmwvc_analysis.recording.salvage import RawMessage
from pmwvc_analysis.recording.writer import SessionWriter

QUEUE_BYTES = 256 << 20  # more than a minute of a session of eight users, 3.5 MiB a second
FLUSH_S = 1.0


class BackgroundWriter:
    """Hands messages to a :class:`SessionWriter` in a thread of its own.

    Only that thread touches the writer until :meth:`close` returns, and it calls ``prepare``
    first, such as for a scheduling class of its own. ``capacity_bytes`` of messages may wait.
    """

    def __init__(
        self,
        writer: SessionWriter,
        *,
        capacity_bytes: int = QUEUE_BYTES,
        prepare: Callable[[], object] = lambda: None,
    ) -> None:
        self.writer = writer
        self.overrun: Counter[str] = Counter()
        self.most_waiting_bytes = 0
        self._capacity = capacity_bytes
        self._waiting: deque[Sequence[RawMessage]] = deque()
        self._bytes = 0  # of what waits
        self._ending = False
        self._news = threading.Condition()
        self._prepare = prepare
        self._thread = threading.Thread(target=self._run, name="writer")
        self._thread.start()

    def put(self, messages: Sequence[RawMessage]) -> None:
        """Take messages; never waits for the disk."""
        size = sum(len(message.data) for message in messages)
        with self._news:
            if self._bytes + size > self._capacity:
                self.overrun.update(message.topic for message in messages)
                return
            self._waiting.append(messages)
            self._bytes += size
            self.most_waiting_bytes = max(self.most_waiting_bytes, self._bytes)
            self._news.notify()

    def close(self) -> list[str]:
        """Write what waits, complete the recording, and return what is missing in it and why, one
        line each.
        """
        if self._thread.is_alive():
            with self._news:
                self._ending = True
                self._news.notify()
            self._thread.join()
            losses = {}
            for topic, messages in self.writer.counter.messages.items():
                missing = f"{self.writer.counter.missing(topic)} numbers missing"
                unqueued = f"{self.overrun[topic]} not queued"
                losses[topic] = f"{messages} messages, {missing}, {unqueued}"
            self.writer.add_metadata("losses", losses)
            self.writer.close()
        found = [f"{topic}: {n} did not fit the queue" for topic, n in self.overrun.items()]
        if self.writer.problem:
            found.append(f"{self.writer.problem}; {self.writer.refused} messages not written")
        return found + self.writer.counter.lines()

    def _run(self) -> None:
        self._prepare()
        flush_at = time.monotonic()
        while True:
            if time.monotonic() >= flush_at:
                flush_at += FLUSH_S
                self.writer.flush()
                self.writer.refresh_metadata()
            with self._news:
                if not self._waiting and not self._ending:
                    self._news.wait(max(flush_at - time.monotonic(), 0.0))
                if not self._waiting:
                    if self._ending:
                        return
                    continue
                messages = self._waiting.popleft()
                self._bytes -= sum(len(message.data) for message in messages)
            for topic, _, log_ns, publish_ns, data in messages:
                self.writer.write(topic, data, log_ns=log_ns, publish_ns=publish_ns)
