# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Where words go: with ``--json``, stdout carries one document and nothing else."""

import contextlib
import json
import os
import sys
from collections.abc import Callable, Iterator
from typing import Any


@contextlib.contextmanager
def document(*, wanted: bool) -> Iterator[Callable[[str | dict[str, Any]], None]]:
    """Yield a function that prints the document; everything else printed meanwhile is for people.

    With ``wanted``, the file descriptor of stdout points to stderr inside the block, so that
    libraries and children cannot write into the document; without, the function prints nothing.
    """
    if not wanted:
        yield lambda _: None
        return
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)

    def write(content: str | dict[str, Any]) -> None:
        text = content if isinstance(content, str) else json.dumps(content, indent=2)
        with open(kept, "w", encoding="utf-8", closefd=False) as stdout:
            stdout.write(text if text.endswith("\n") else text + "\n")

    try:
        yield write
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
