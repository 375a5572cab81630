# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A live session as the tests see it: ``./pmwvc run`` and the nodes it started."""

import json
import os
import signal
import subprocess
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class Ended:
    """A session that was recorded into a folder by a command, and what that printed."""

    def __init__(self, folder: Path, printed: str = "") -> None:
        self.folder, self._printed = folder, printed

    def output(self) -> str:
        """Return what was printed."""
        return self._printed

    def summary(self) -> dict:
        """Return ``summary.json``."""
        return json.loads((self.folder / "summary.json").read_text("utf-8"))

    def events(self) -> list[dict]:
        """Return what the runner noted."""
        return json.loads((self.folder / "events.json").read_text("utf-8"))

    def nodes(self) -> dict[str, int]:
        """Return the nodes that are alive by the name of their log, with their process ids."""
        found = {}
        for process in Path("/proc").glob("[0-9]*"):
            try:
                words = (process / "cmdline").read_bytes().split(b"\0")
            except (FileNotFoundError, ProcessLookupError):
                continue
            for word in map(os.fsdecode, words):
                if word.startswith(f"{self.folder.resolve()}/nodes/"):
                    found[Path(word).stem] = int(process.name)
        return found


class Running(Ended):
    """One ``./pmwvc run`` with its folder; ``with`` ends everything that is left.

    ``figures``: whether it draws the report at its end, which takes as long as a short session.
    """

    def __init__(self, folder: Path, *words: object, figures: bool = False) -> None:
        super().__init__(folder)
        words = words if figures else (*words, "--no-figures")
        folder.parent.mkdir(parents=True, exist_ok=True)
        self._errors = (folder.parent / "stderr").open("w+")
        self.process = subprocess.Popen(
            [ROOT / "pmwvc", "run", *map(str, words), "--out", folder],
            cwd=folder.parent,
            env=without_domain(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
        )
        self.lines: list[str] = []

    def __enter__(self) -> "Running":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait()
        for pid in self.nodes().values():
            os.kill(pid, signal.SIGKILL)
        self.process.stdout.close()
        self._errors.close()

    def await_line(self, text: str) -> str:
        """Read on to the first line that holds the text."""
        for line in self.process.stdout:
            self.lines.append(line)
            if text in line:
                return line
        raise AssertionError(f"ended without printing {text!r}:\n{self.output()}")

    def await_ticks(self) -> None:
        """Read on until the first line of status: the loops are running."""
        self.await_line(" Hz ")

    def domain(self) -> int:
        """Read on to the ROS domain of its nodes."""
        return int(self.await_line("ROS_DOMAIN_ID=").rpartition("=")[2])

    def end(self) -> int:
        """Read to the end and return the exit code."""
        self.lines += self.process.stdout
        return self.process.wait()

    def output(self) -> str:
        """Return everything it printed, stderr last."""
        self._errors.flush()
        return "".join(self.lines) + Path(self._errors.name).read_text()

    def await_no_nodes(self) -> None:
        """Wait until every node is gone."""
        while self.nodes():
            time.sleep(0.02)


def without_domain() -> dict[str, str]:
    """Return this process's environment, in which a session takes a domain of its own."""
    return {name: value for name, value in os.environ.items() if name != "ROS_DOMAIN_ID"}


def shared_memory_of(pid: int) -> list[str]:
    """Return the files in ``/dev/shm`` that a process has mapped or open."""
    maps = Path(f"/proc/{pid}/maps").read_text().splitlines()
    files = [os.readlink(path) for path in Path(f"/proc/{pid}/fd").iterdir() if path.is_symlink()]
    # lttng: opened by the tracing library of ROS, one file for all programs
    return [text for text in (*maps, *files) if "/dev/shm" in text and "lttng" not in text]
