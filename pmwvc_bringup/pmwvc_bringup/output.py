# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Output of the commands: texts for people, and with ``--json`` one document alone on stdout."""

import contextlib
import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from pmwvc_core.errors import file_errors

if TYPE_CHECKING:
    from pmwvc_analysis.charts.chart import Chart

LINE_S = 10.0  # between two lines of progress where there is no terminal


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
    from pmwvc_analysis.charts.chart_png import write
    from pmwvc_analysis.session_files import write_summary

    with file_errors(f"write into {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        paths = [*others, *write(chart, folder), folder / f"{name}.json"]
        write_summary(folder, content, name=paths[-1].name)
    print(f"written: {folder} ({', '.join(path.name for path in paths)})")


def terminal() -> Console:
    """Return the console for people."""
    return Console(highlight=False, soft_wrap=True)


@contextlib.contextmanager
def progress(
    console: Console, text: str, clock: Callable[[], float] = time.monotonic
) -> Iterator[Callable[[float], None]]:
    """Yield a function that shows a ratio: by a bar where the console is a terminal, else by a
    line every ``LINE_S`` seconds of the clock [s].
    """
    if console.is_terminal:
        from rich.progress import Progress

        with Progress(console=console, transient=True) as bar:
            task = bar.add_task(text, total=1.0)
            yield lambda ratio: bar.update(task, completed=ratio)
        return
    due_s = clock() + LINE_S

    def show(ratio: float) -> None:
        nonlocal due_s
        if clock() >= due_s:
            due_s = clock() + LINE_S
            console.print(f"{text}: {100.0 * ratio:.0f} %", markup=False)

    yield show
