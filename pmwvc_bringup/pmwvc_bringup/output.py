# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Output of the commands: texts for people, what a command is doing, and with ``--json`` one
document alone on stdout.
"""

import contextlib
import json
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress


@contextlib.contextmanager
def document(*, wanted: bool) -> Iterator[Callable[[object], None]]:
    """Yield a function that prints the document; all else printed meanwhile is for people.

    With ``wanted``, what is printed inside the block goes to stderr; without, the function prints
    nothing.
    """
    stdout = sys.stdout

    def write(content: object) -> None:
        if wanted and content is not None:
            text = content if isinstance(content, str) else json.dumps(content, indent=2)
            stdout.write(text if text.endswith("\n") else text + "\n")

    with contextlib.redirect_stdout(sys.stderr) if wanted else contextlib.nullcontext():
        yield write


def terminal(*, stderr: bool = False) -> "Console":
    """Return the console for people."""
    from rich.console import Console

    return Console(stderr=stderr, highlight=False, soft_wrap=True)


class Doing:
    """One part of a command's work after the other, as a bar; called with a ratio it shows that as
    well.
    """

    def __init__(self, bar: "Progress", text: str) -> None:
        self._bar = bar
        self.part(text)

    def part(self, text: str) -> None:
        """Begin another part."""
        for task in self._bar.task_ids:
            self._bar.remove_task(task)
        self._task = self._bar.add_task(text, total=None)

    def __call__(self, ratio: float) -> None:
        """Tell how much of this part is done, 0 to 1."""
        self._bar.update(self._task, total=1.0, completed=ratio)


@contextlib.contextmanager
def doing(text: str) -> Iterator[Doing]:
    """Show work while it lasts, on stderr where that is a terminal."""
    from rich.progress import Progress

    to = terminal(stderr=True)
    with Progress(console=to, transient=True, disable=not to.is_interactive) as bar:
        yield Doing(bar, text)
