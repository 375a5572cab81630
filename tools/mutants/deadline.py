# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Plug-in of pytest for the tests of a mutant: no test begins after ``MUTANT_S`` seconds, and the
product is that of the tree with the tests.
"""

import importlib
import os
import time
from pathlib import Path

import pytest

END_S = time.monotonic() + float(os.environ["MUTANT_S"])


def pytest_sessionstart(session: pytest.Session) -> None:
    """Refuse to run where another tree would be imported."""
    for name in ("pmwvc_core", "pmwvc_analysis"):
        file = Path(importlib.import_module(name).__file__ or "")
        if session.config.rootpath not in file.parents:
            pytest.exit(f"{file} is not in {session.config.rootpath}", returncode=9)


def pytest_runtest_teardown(item: pytest.Item) -> None:
    """Stop once the time is over."""
    if time.monotonic() > END_S:
        item.session.shouldstop = "the time is over"
