# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Requests to end a program: counted, or kept from a child while it starts. Needs no ROS.

Only SIGINT and SIGTERM exist on every system, and only POSIX can block a signal.
"""

import contextlib
import signal
from collections.abc import Iterator
from types import FrameType


class Interrupts:
    """Counts requests to end: Ctrl-C, a termination, a closed terminal."""

    def __init__(self) -> None:
        self.count = 0

    @contextlib.contextmanager
    def caught(self) -> Iterator["Interrupts"]:
        """Count signals inside the block instead of ending by them."""
        numbers = [signal.SIGINT, signal.SIGTERM]
        hang_up = getattr(signal, "SIGHUP", None)
        if hang_up is not None and signal.getsignal(hang_up) != signal.SIG_IGN:  # nohup
            numbers.append(hang_up)
        before = {number: signal.signal(number, self._take) for number in numbers}
        try:
            yield self
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def is_set(self) -> bool:
        """Tell whether there was one."""
        return self.count > 0

    def _take(self, _: int, __: FrameType | None) -> None:
        self.count += 1


@contextlib.contextmanager
def held_back() -> Iterator[None]:
    """Let a Ctrl-C wait until the end of the block; children started inside see none."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
