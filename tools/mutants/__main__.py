# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Put defects into the product, one at a time, and print those that no test notices.

``COUNT`` of them (100), drawn with ``SEED`` (1), one per line of source at most. Each is tried in
a copy of the tree against the tests that concern its file, for ``LIMIT_S`` seconds (180), on all
cores. A test that fails counts if it passes without the defect. Whoever reads what survived
decides whether it matters: some defects change nothing that can be seen.
"""

import ast
import difflib
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple

from mutants.concerned import concerned_tests
from mutants.operators import Defect, defects

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = {
    "pmwvc_core/pmwvc_core": (
        *("law", "plant", "wave", "master", "server", "controllers", "transport"),
    ),
    "pmwvc_analysis/pmwvc_analysis": ("verdicts", "budget", "recording"),
}
LEFT_OUT = (".git", ".venv", ".ros", "sessions", "__pycache__", ".*_cache", ".hypothesis")
LIMIT_S = float(os.environ.get("LIMIT_S", 180))
HANGS = "it hangs"


class Mutant(NamedTuple):
    """A defect in a file, relative to the tree."""

    file: Path
    defect: Defect

    def __str__(self) -> str:
        return f"{self.file}:{self.defect.line} ({self.defect.kind})"

    def diff(self) -> str:
        """Return the lines that change."""
        source = (ROOT / self.file).read_text("utf-8")
        old, new = ast.unparse(ast.parse(source)), self.defect.put_into(source)
        lines = difflib.unified_diff(old.splitlines(), new.splitlines(), n=0, lineterm="")
        return "\n".join(f"    {line}" for line in lines if line[:3] not in ("---", "+++", "@@ "))


def drawn(count: int, seed: int) -> list[Mutant]:
    """Return mutants of the files of the folders, the same for the same seed."""
    folders = [ROOT / top / name for top, names in FOLDERS.items() for name in names]
    files = [file for folder in folders for file in sorted(folder.rglob("*.py"))]
    every = [Mutant(f.relative_to(ROOT), each) for f in files for each in defects(f.read_text())]
    random.Random(seed).shuffle(every)
    one_per_line = {(each.file, each.defect.line): each for each in every}
    return list(one_per_line.values())[:count]


class Copy:
    """A copy of the tree, in which one mutant at a time is tried."""

    sound: set[str]  # tests that failed with a mutant and pass without

    def __init__(self, root: Path) -> None:
        self.root, self.sound, self._changes = root, {HANGS}, 0
        shutil.copytree(ROOT, root, ignore=shutil.ignore_patterns(*LEFT_OUT))
        for name in (".venv", ".ros"):
            (root / name).symlink_to(ROOT / name)

    def killer(self, mutant: Mutant) -> str | None:
        """Return the test that notices a mutant; None where none does within the time."""
        file = self.root / mutant.file
        source, tests = file.read_text("utf-8"), concerned_tests(self.root, file)
        unsound: list[str] = []
        while True:
            self._write(file, mutant.defect.put_into(source))
            failed = self._failing(tests, unsound)
            self._write(file, source)
            if failed is None or failed in self.sound:
                return failed
            if self._failing([failed], []) is None:
                self.sound.add(failed)
                return failed
            unsound.append(failed)

    def _write(self, file: Path, source: str) -> None:
        """Write a source with a time of its own, by which Python knows what to compile again."""
        file.write_text(source, "utf-8")
        self._changes += 1
        os.utime(file, (1e9 + self._changes,) * 2)

    def _failing(self, tests: list[str], unsound: list[str]) -> str | None:
        """Run tests until the first one fails; return its name."""
        paths = [*map(str, self.root.glob("pmwvc_*")), str(self.root / "tools")]
        told = {"PYTHONPATH": os.pathsep.join(paths), "MUTANT_S": str(LIMIT_S), "CI": "1"}
        command = [str(ROOT / ".venv/bin/python"), "-m", "pytest", "-xq", "--tb=no", "-rfE"]
        command += ["-p", "mutants.deadline", "-o", "timeout=100", *tests]
        command += [f"--deselect={each}" for each in unsound]
        try:
            ran = subprocess.run(
                command,
                cwd=self.root,
                env=os.environ | told,
                text=True,
                capture_output=True,
                timeout=LIMIT_S + 110,
            )
        except subprocess.TimeoutExpired:
            return HANGS
        for line in ran.stdout.splitlines():
            if line.startswith(("FAILED ", "ERROR ")):
                return line.split(" ", 1)[1].split(" - ")[0]
        if ran.returncode not in (0, 2, 5):  # passed, out of time, all deselected
            sys.exit(f"pytest: {ran.stdout[-2000:]}{ran.stderr[-2000:]}")
        return None


def main() -> int:
    """Draw mutants, try them, print what survived; 1 where any did."""
    count, seed = int(os.environ.get("COUNT", 100)), int(os.environ.get("SEED", 1))
    mutants, cores = drawn(count, seed), len(os.sched_getaffinity(0))
    survived: list[Mutant] = []
    with tempfile.TemporaryDirectory(prefix="mutants") as folder:
        copies: SimpleQueue[Copy] = SimpleQueue()
        for core in range(cores):
            copies.put(Copy(Path(folder) / str(core)))

        def try_one(mutant: Mutant) -> None:
            copy, begun_s = copies.get(), time.monotonic()
            killer = copy.killer(mutant)
            copies.put(copy)
            if killer is None:
                survived.append(mutant)
            took_s = time.monotonic() - begun_s
            print(f"{took_s:5.0f} s  {mutant}: {killer or 'SURVIVED'}", flush=True)

        with ThreadPoolExecutor(cores) as threads:
            list(threads.map(try_one, mutants))
    for mutant in survived:
        print(f"\n{mutant}\n{mutant.diff()}")
    share = len(survived) / max(len(mutants), 1)
    print(f"\n{len(survived)} of {len(mutants)} mutants survived ({share:.0%}), seed {seed}")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
