# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What all tests share: hypothesis profiles and the recorded data beside the project."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

RECORDED_DATA = Path(__file__).resolve().parents[1].parent / "shared" / "data"

settings.register_profile("local", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Keep tests with live nodes on one worker: two 1 kHz sessions at once are not two users."""
    for item in items:
        if "integration" in Path(item.fspath).parts:
            item.add_marker(pytest.mark.xdist_group("live"))


@pytest.fixture(scope="session")
def recorded_data() -> Path:
    """Return the folder of recorded motions and delays."""
    if not RECORDED_DATA.is_dir():
        pytest.skip(f"no recorded data at {RECORDED_DATA}")
    return RECORDED_DATA
