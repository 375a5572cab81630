# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Requests to end a program, counted. Needs no ROS.

Only SIGINT and SIGTERM exist on every system.
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
