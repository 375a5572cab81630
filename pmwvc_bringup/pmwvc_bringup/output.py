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
LINE_S = 10.0  # between two lines of one part where there is no terminal
LOOK_S = 0.1


class Doing:
    """One part of a command's work after the other, each shown once it has lasted ``QUIET_S``: by
    a bar on a terminal, else by lines. Called with a ratio it shows that as well.
    """

    def __init__(self, text: str) -> None:
        self.part(text)

    def part(self, text: str) -> None:
        """Begin another part."""
        self._now: tuple[str, float, float | None] = text, time.monotonic(), None

    def __call__(self, ratio: float) -> None:
        """Tell how much of this part is done, 0 to 1."""
        self._now = (*self._now[:2], ratio)

    def show(self, console: "Console", ended: threading.Event) -> None:
        """Show the part of each moment until all have ended."""
        if ended.wait(QUIET_S):
            return
        from rich.progress import Progress

        drawn, line_s, shown = console.is_interactive, 0.0, ""
        with Progress(console=console, transient=True, disable=not drawn) as bar:
            while not ended.wait(LOOK_S):
                text, begin_s, ratio = self._now
                if time.monotonic() < begin_s + QUIET_S:
                    continue
                if drawn:
                    whole = None if ratio is None else 1.0
                    tasks = bar.task_ids or [bar.add_task(text, total=None)]
                    bar.update(tasks[0], description=text, total=whole, completed=ratio or 0.0)
                elif text != shown or (ratio is not None and time.monotonic() >= line_s):
                    done = "" if ratio is None else f": {100.0 * ratio:.0f} %"
                    console.print(f"{text}{done}", markup=False)
                    line_s, shown = time.monotonic() + LINE_S, text


@contextlib.contextmanager
def doing(text: str, console: "Console | None" = None) -> Iterator[Doing]:
    """Name work while it lasts, on stderr by default."""
    work, ended = Doing(text), threading.Event()
    to = console or terminal(stderr=True)
    thread = threading.Thread(target=work.show, args=(to, ended), daemon=True)
    thread.start()
    try:
        yield work
    finally:
        ended.set()
        thread.join()
