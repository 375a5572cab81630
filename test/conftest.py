# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The setup of all tests: order, hypothesis profiles, recorded data, compiled modules."""

import os
import sys
from pathlib import Path

import pytest
from hypothesis import settings

RECORDED_DATA = Path(__file__).parent / "data"
# Quick ones first. On several workers those with live nodes come first, all on one worker: they
# wait more than they compute, and last they would keep the other workers waiting.
ORDER = ("project", "unit", "property", "oracle", "browser", "integration")
LIVE = ("browser", "integration")
if "PYTEST_XDIST_WORKER" in os.environ:
    ORDER = (*LIVE, *(folder for folder in ORDER if folder not in LIVE))

# Several hundred processes start: each module is compiled once, whatever the machine prefers.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.setdefault("PYTHONPYCACHEPREFIX", str(Path(__file__).parents[1] / ".pytest_cache/code"))
sys.dont_write_bytecode, sys.pycache_prefix = False, os.environ["PYTHONPYCACHEPREFIX"]

settings.register_profile("local", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the tests in order, and those with live nodes or a browser on one worker: two 1 kHz
    sessions at once are not two users.
    """
    items.sort(key=lambda item: ORDER.index(_folder(item)))
    for item in items:
        if _folder(item) in LIVE:
            item.add_marker(pytest.mark.xdist_group("live"))


def _folder(item: pytest.Item) -> str:
    """Return the folder of the tests that an item is in."""
    return Path(item.fspath).relative_to(Path(__file__).parent).parts[0]


@pytest.fixture(scope="session")
def recorded_data() -> Path:
    """Return the folder of recorded motions and delays."""
    return RECORDED_DATA
