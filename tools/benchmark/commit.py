# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The commit whose sources a run used, in words."""

import subprocess
from pathlib import Path


def commit() -> str:
    """Return the commit of this tree, and whether it had been changed."""
    here = Path(__file__).parent

    def git(*words: str) -> str:
        return subprocess.run(
            ["git", *words], cwd=here, check=True, capture_output=True, text=True
        ).stdout.strip()

    try:
        changed = git("status", "--porcelain", "--untracked-files=no")
        return f"commit {git('rev-parse', '--short=10', 'HEAD')}" + (
            ", changed" if changed else ""
        )
    except (OSError, subprocess.CalledProcessError):
        return "sources without a commit"
