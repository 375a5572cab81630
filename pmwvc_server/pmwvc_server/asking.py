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
from concurrent.futures import Future
from typing import Any

from pmwvc_core.errors import PLUGIN_ERRORS
from pmwvc_core.params import ServerParams
from pmwvc_core.plugins import Unanswered
from pmwvc_core.server.black_box import Call, directly
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.server.environments import environment_of

WAIT_RATIO = 0.5  # of the period that the loop waits
_PRIORITY = 10  # below the loop, above other programs
Question = tuple[Callable[[], Any], "Future[Any]"]  # and where its answer goes


def caller(params: ServerParams) -> Call:
    """Return how the environment of a server is asked."""
    black_box, asked = COUPLINGS.of(params.coupling).black_box, environment_of(params.environment)
    at_once = not black_box or asked.made or asked.prompt
    return directly if at_once else Worker(WAIT_RATIO * params.period_s)


class Worker:
    """Runs one exchange at a time in a thread of its own."""

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._questions: queue.SimpleQueue[Question] = queue.SimpleQueue()
        self._asked_s = 0.0
        self._answer: Future[Any] | None = None  # to the last question
        threading.Thread(target=self._work, name="environment", daemon=True).start()

    def __call__(self, exchange: Callable[[], Any]) -> Any:
        """Return the answer, or raise the environment's error, or Unanswered after too long."""
        if self._answer is not None and not self._answer.done():
            busy_s = time.monotonic() - self._asked_s
            raise Unanswered(f"is still busy with the step of {busy_s:.2f} s ago")
        self._asked_s, self._answer = time.monotonic(), Future()
        self._questions.put((exchange, self._answer))
        try:
            error = self._answer.exception(self._patience_s)
        except TimeoutError:
            raise Unanswered(f"has not answered within {1e3 * self._patience_s:.3g} ms") from None
        if error is not None:
            raise error
        return self._answer.result()

    def _work(self) -> None:
        with contextlib.suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
        while True:
            exchange, answer = self._questions.get()
            try:
                answer.set_result(exchange())
            except PLUGIN_ERRORS as error:
                answer.set_exception(error)
