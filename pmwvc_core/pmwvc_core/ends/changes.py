# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Changes that both ends take from other threads."""

from collections import deque
from collections.abc import Callable


class Changing:
    """An end whose parameters may change while it runs.

    Attributes
    ----------
    changes
        Frames or steps that took changes over.
    """

    def __init__(self) -> None:
        self.changes = 0
        self._waiting: deque[Callable[[], None]] = deque()

    def hand_over(self, change: Callable[[], None]) -> None:
        """Have a change made at the next occasion; from any thread."""
        self._waiting.append(change)

    def _take_changes(self) -> None:
        """Make the changes that were handed over."""
        if self._waiting:
            self.changes += 1
        while self._waiting:
            self._waiting.popleft()()
