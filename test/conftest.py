# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The setup of all tests: order, workers, hypothesis profiles, recorded data, compiled modules."""

import os
import signal
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

RECORDED_DATA = Path(__file__).parent / "data"
# Quick ones first.
ORDER = ("project", "law", "unit", "property", "oracle", "browser", "integration")
LIVE = ("browser", "integration")  # with real nodes or a browser
# Fakes of one device have one serial number, which only one process may claim at a time.
FAKES = {
    f"test_{name}.py"
    for name in (
        *("device_list", "force_dimension", "haply", "haply_service"),
        *("touch", "vendor_devices"),
    )
}
if "PYTEST_XDIST_WORKER" in os.environ:
    # On several workers long files come first: last they would keep the other workers waiting.
    ORDER = (*LIVE, "law", "oracle", "project", "property", "unit")


# Several hundred processes start: each module is compiled once, whatever the machine prefers.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.setdefault("PYTHONPYCACHEPREFIX", str(Path(__file__).parents[1] / ".pytest_cache/code"))
sys.dont_write_bytecode, sys.pycache_prefix = False, os.environ["PYTHONPYCACHEPREFIX"]

# What a shell puts in the background ignores interrupts, and so would all that the tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A quarter of hypothesis' own number: the properties run with every change.
settings.register_profile("local", deadline=None, max_examples=25)
settings.register_profile("ci", settings.get_profile("local"), derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


class ByFile(LoadScopeScheduling):
    """The tests of a file on one worker, so that what they share is made once; all with live nodes
    on one: two 1 kHz sessions at once are not two users.
    """

    def _split_scope(self, nodeid: str) -> str:
        file = Path(nodeid.partition("::")[0])
        if file.name in FAKES:
            return "fakes"
        return "live" if file.parts[1] in LIVE else str(file)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> ByFile:
    """Return what deals the tests out to several workers."""
    return ByFile(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the tests in order."""
    items.sort(key=lambda item: ORDER.index(_folder(item)))


def _folder(item: pytest.Item) -> str:
    """Return the folder of the tests that an item is in."""
    return Path(item.fspath).relative_to(Path(__file__).parent).parts[0]


@pytest.fixture(scope="session")
def recorded_data() -> Path:
    """Return the folder of recorded motions and delays."""
    return RECORDED_DATA
