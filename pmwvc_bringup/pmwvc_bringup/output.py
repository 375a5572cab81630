# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Output of the commands: texts for people, what a command is doing as soon as it lasts, and with
``--json`` one document alone on stdout.
"""

import contextlib
import json
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmwvc_core.errors import file_errors

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

    from pmwvc_analysis.charts.chart import Chart


@contextlib.contextmanager
def document(*, wanted: bool) -> Iterator[Callable[[object], None]]:
    """Yield a function that prints the document; all else printed meanwhile is for people.

    With ``wanted``, the file descriptor of stdout points to stderr inside the block, so that
    libraries and children cannot write into the document; without, the function prints nothing.
    """
    if not wanted:
        yield lambda _: None
        return
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)

    def write(content: object) -> None:
        if content is None:
            return
        text = content if isinstance(content, str) else json.dumps(content, indent=2)
        with open(kept, "w", encoding="utf-8", closefd=False) as stdout:
            stdout.write(text if text.endswith("\n") else text + "\n")

    try:
        yield write
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)


def write_answer(
    folder: Path, name: str, content: dict[str, Any], chart: "Chart", others: Sequence[Path] = ()
) -> None:
    """Write numbers and figure of an answer into a folder, and print the names of all files."""
    from pmwvc_analysis.charts.chart_files import write
    from pmwvc_analysis.session_files import write_summary

    with file_errors(f"write into {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        paths = [*others, *write(chart, folder), folder / f"{name}.json"]
        write_summary(folder, content, name=paths[-1].name)
    print(f"written: {folder} ({', '.join(path.name for path in paths)})")


def terminal(*, stderr: bool = False) -> "Console":
    """Return the console for people."""
    from rich.console import Console

    return Console(stderr=stderr, highlight=False, soft_wrap=True)


QUIET_S = 2.0  # what takes less is not mentioned
LINE_S = 10.0  # between two lines of one ratio where there is no terminal


class Doing:
    """One part of a command's work after the other, each named on stderr once it has lasted
    ``QUIET_S``: a bar on a terminal, else lines. Called with a ratio it shows that as well.
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
            if self._text and self._console.is_interactive:
                self._bar = Progress(console=self._console, transient=True)
                self._bar.add_task(self._text, total=None)
                self._bar.start()
            elif self._text:
                self._line()

    def _line(self) -> None:
        done = "" if self._ratio is None else f": {100.0 * self._ratio:.0f} %"
        self._console.print(f"{self._text}{done}", markup=False)
        self._line_s = time.monotonic() + LINE_S


@contextlib.contextmanager
def doing(text: str, console: "Console | None" = None) -> Iterator[Doing]:
    """Name work while it lasts, on stderr by default."""
    work = Doing(console or terminal(stderr=True))
    work.part(text)
    try:
        yield work
    finally:
        work.end()
