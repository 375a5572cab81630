# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a command is doing, on stderr, as soon as it lasts: a bar on a terminal, else lines."""

import contextlib
import threading
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

QUIET_S = 2.0  # what takes less is not mentioned
LINE_S = 10.0  # between two lines of one ratio where there is no terminal


class Doing:
    """One part of a command's work after the other, each named once it has lasted ``QUIET_S``.

    Called with a ratio it shows that as well.
    """

    def __init__(self, console: "Console") -> None:
        self._console = console
        self._lock = threading.Lock()
        self._timer = threading.Timer(0.0, self._show)
        self._text = ""
        self._ratio: float | None = None
        self._bar: Progress | None = None
        self._line_s: float | None = None  # when the next line is due

    def part(self, text: str) -> None:
        """Begin another part."""
        with self._lock:
            self._timer.cancel()
            self._text, self._ratio, self._line_s = text, None, None
            if self._bar is not None:
                self._bar.reset(self._bar.task_ids[0], description=text, total=None)
                return
            self._timer = threading.Timer(QUIET_S, self._show)
            self._timer.daemon = True
            self._timer.start()

    def __call__(self, ratio: float) -> None:
        """Show how much of this part is done, 0 to 1."""
        with self._lock:
            self._ratio = ratio
            if self._bar is not None:
                self._bar.update(self._bar.task_ids[0], total=1.0, completed=ratio)
            elif self._line_s is not None and time.monotonic() >= self._line_s:
                self._line()

    def end(self) -> None:
        """Say nothing more."""
        with self._lock:
            self._timer.cancel()
            self._text = ""
            if self._bar is not None:
                self._bar.stop()

    def _show(self) -> None:
        from rich.progress import Progress

        with self._lock:
            if not self._text:
                return
            if self._console.is_interactive:
                self._bar = Progress(console=self._console, transient=True)
                self._bar.add_task(self._text, total=None)
                self._bar.start()
            else:
                self._line()

    def _line(self) -> None:
        done = "" if self._ratio is None else f": {100.0 * self._ratio:.0f} %"
        self._console.print(f"{self._text}{done}", markup=False)
        self._line_s = time.monotonic() + LINE_S


@contextlib.contextmanager
def doing(text: str, console: "Console | None" = None) -> Iterator[Doing]:
    """Name work while it lasts, on stderr by default."""
    from rich.console import Console

    work = Doing(console or Console(stderr=True, highlight=False, soft_wrap=True))
    work.part(text)
    try:
        yield work
    finally:
        work.end()
