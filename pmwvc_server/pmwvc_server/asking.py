# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The call of a live server's environment: of its own directly, of a plug-in through a thread.

A plug-in may take too long or never come back. The loop waits for part of its period; then it
goes on without an answer, and does not ask again before the plug-in is back. An answer that comes
late is not used.

Not guarded against: a plug-in that holds the interpreter (a compiled library that does not give it
back) stops every thread of the process.
"""

import contextlib
import os
import queue
import threading
import time
from collections.abc import Callable
from typing import Any

from pmwvc_core.errors import PLUGIN_ERRORS
from pmwvc_core.params import ServerParams
from pmwvc_core.server.black_box.containment import Call, directly
from pmwvc_core.server.black_box.faults import Unanswered
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.server.environments import LIBRARY

WAIT_RATIO = 0.5  # of the period that the loop waits
_PRIORITY = 10  # below the loop, above other programs


def caller(params: ServerParams) -> Call:
    """Return how the environment of a server is asked."""
    if not COUPLINGS.of(params.coupling).black_box or params.environment in LIBRARY:
        return directly
    return Worker(WAIT_RATIO * params.period_s)


class _Job:
    """A question, and what came of it."""

    def __init__(self, exchange: Callable[[], Any]) -> None:
        self.exchange = exchange
        self.asked_s = time.monotonic()
        self.done = threading.Event()
        self.answer: Any = None
        self.error: BaseException | None = None

    def work(self) -> None:
        try:
            self.answer = self.exchange()
        except PLUGIN_ERRORS as error:
            self.error = error
        self.done.set()


class Worker:
    """Runs one exchange at a time in a thread of its own."""

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._jobs: queue.SimpleQueue[_Job] = queue.SimpleQueue()
        self._last: _Job | None = None
        threading.Thread(target=self._work, name="environment", daemon=True).start()

    def __call__(self, exchange: Callable[[], Any]) -> Any:
        """Return the answer, or raise the environment's error, or Unanswered after too long."""
        last = self._last
        if last is not None and not last.done.is_set():
            busy_s = time.monotonic() - last.asked_s
            raise Unanswered(f"is still busy with the step of {busy_s:.2f} s ago")
        self._last = job = _Job(exchange)
        self._jobs.put(job)
        if not job.done.wait(self._patience_s):
            raise Unanswered(f"has not answered within {1e3 * self._patience_s:.3g} ms")
        if job.error is not None:
            raise job.error
        return job.answer

    def _work(self) -> None:
        with contextlib.suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
        while True:
            self._jobs.get().work()
