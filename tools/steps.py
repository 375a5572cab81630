# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The steps of the set-up, each named as it begins and again while it lasts."""

import contextlib
import subprocess
import time
from pathlib import Path
from typing import Any

AGAIN_S = 5.0  # between two lines on the same step


def report(text: str) -> None:
    """Print one line at once."""
    print(f"setup_ros: {text}", flush=True)


def run(text: str, command: list[Any], env: dict[str, str], cwd: Path | None = None) -> None:
    """Run a command; say what it is for, and again while it lasts. CalledProcessError."""
    report(text)
    begin_s = time.monotonic()
    with subprocess.Popen(command, env=env, cwd=cwd) as process:
        while process.poll() is None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(AGAIN_S)
                break
            report(f"{text}: {time.monotonic() - begin_s:.0f} s so far")
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
