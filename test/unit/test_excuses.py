# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The excuse of a machine that stands still: two more runs, with sessions of their own."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

CONFTEST = "from support.excuses import pytest_runtest_makereport, pytest_runtest_protocol\n"
TESTS = """
import pytest
from support.excuses import unless_stalled

pytestmark = pytest.mark.integration
made = []

@pytest.fixture(scope="session")
def session():
    made.append(None)
    return len(made)

def test_one(session):
    with unless_stalled(lambda: {stalled}):
        assert session > {wanted}
"""


@pytest.mark.parametrize(
    ("wanted", "stalled", "runs", "outcome"),
    [(0, True, 1, "1 passed"), (2, True, 3, "1 passed"), (3, True, 3, "1 failed"),
     (1, False, 1, "1 failed")],
)  # fmt: skip
def test_only_a_stall_excuses_and_twice_at_most(tmp_path, wanted, stalled, runs, outcome):
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "test_it.py").write_text(TESTS.format(wanted=wanted, stalled=stalled))
    words = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-c", "/dev/null", tmp_path]
    here = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])}
    text = subprocess.run(words, capture_output=True, text=True, check=False, env=here).stdout
    assert outcome in text
    assert len(re.findall(r"run again \(\d left\)", text)) == runs - 1
