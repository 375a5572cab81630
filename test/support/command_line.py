# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``./pmwvc`` in a process of its own, as a person or a program meets it."""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def call(*words, cwd, **environment):
    """Run ``./pmwvc`` with words in a folder; the result has code, stdout and stderr as text."""
    return subprocess.run(
        [ROOT / "pmwvc", *map(str, words)],
        cwd=cwd,
        env=os.environ | environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )


def refused(result):
    """Return the message of a refusal: on stderr, one message, no traceback."""
    assert result.returncode == 2
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    return result.stderr
