# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The call of a live server's environment: of its own directly, of a plug-in through a thread.

A plug-in may take too long or never come back. The loop waits for part of its period, goes on
without an answer, and does not ask again before the plug-in is back; a late answer is not used. A
scene is asked directly until it is slow. Not guarded against: one that holds the interpreter.
"""

import operator
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from pmwvc_core.errors import PLUGIN_ERRORS
from pmwvc_core.params import ServerParams
from pmwvc_core.plugins import Unanswered
from pmwvc_core.runtime.pacing import request_priority
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.server.environments import LIBRARY, environment_of

WAIT_RATIO = 0.5  # of the period that the loop waits
SLOW_STEPS = 3  # longer than the period, more than shorter ones: a scene is slow
_PRIORITY = 10  # below the loop, above other programs
Question = tuple[Callable[[], Any], "Future[Any]"]  # and where its answer goes


def caller(params: ServerParams) -> Callable[[Callable[[], Any]], Any]:
    """Return how the environment of a server is asked."""
    black_box, asked = COUPLINGS.of(params.coupling).black_box, environment_of(params.environment)
    if not black_box or asked.made:
        return operator.call
    worker = Worker(WAIT_RATIO * params.period_s)
    return worker.at_once if params.environment in LIBRARY else worker


class Worker:
    """Runs one exchange at a time in a thread of its own."""

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._questions: queue.SimpleQueue[Question] = queue.SimpleQueue()
        self._asked_s, self._slow = 0.0, 0
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

    def at_once(self, exchange: Callable[[], Any]) -> Any:
        """Return the answer in the caller's thread, which runs above others, until it is slow."""
        if self._slow >= SLOW_STEPS:
            return self(exchange)
        until_s, answer = time.thread_time() + self._patience_s / WAIT_RATIO, exchange()
        self._slow = max(self._slow + (1 if time.thread_time() > until_s else -1), 0)
        return answer

    def _work(self) -> None:
        request_priority(_PRIORITY)
        while True:
            exchange, answer = self._questions.get()
            try:
                answer.set_result(exchange())
            except PLUGIN_ERRORS as error:
                answer.set_exception(error)
