# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``./pmwvc`` in a process of its own, as a person or a program meets it, and in this one, where
a process would be no more than its imports.
"""

import contextlib
import os
import subprocess
import tempfile
from pathlib import Path

from pmwvc_bringup import cli

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


def here(*words, cwd):
    """Run the command line in this process; otherwise as :func:`call`."""
    words = [str(word) for word in words]
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as error:
        with contextlib.chdir(cwd), _into(1, out), _into(2, error):
            try:
                code = cli.main(words)
            except SystemExit as ended:
                code = ended.code or 0
        texts = [file.seek(0) or file.read() for file in (out, error)]
    return subprocess.CompletedProcess(words, code, *texts)


@contextlib.contextmanager
def _into(descriptor, file):
    """Have a file take what is written to a descriptor, 1 or 2."""
    redirected = contextlib.redirect_stdout if descriptor == 1 else contextlib.redirect_stderr
    kept = os.dup(descriptor)
    os.dup2(file.fileno(), descriptor)
    try:
        with open(descriptor, "w", encoding="utf-8", closefd=False) as stream, redirected(stream):
            yield
    finally:
        os.dup2(kept, descriptor)
        os.close(kept)


def refused(result):
    """Return the message of a refusal: on stderr, one message, no traceback."""
    assert result.returncode == 2
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    return result.stderr
