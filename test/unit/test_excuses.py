# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The excuse of a machine that stands still: two more runs, with sessions of their own."""

import os
import re
import subprocess
import sys
from pathlib import Path

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


CASES = {  # sessions wanted, a machine that stands still, outcome
    "first": (0, True, "PASSED"),
    "third": (2, True, "PASSED"),
    "fourth": (3, True, "FAILED"),
    "awake": (1, False, "FAILED"),
}


def test_only_a_stall_excuses_and_twice_at_most(tmp_path):
    (tmp_path / "conftest.py").write_text(CONFTEST)
    for name, (wanted, stalled, _) in CASES.items():
        text = TESTS.format(wanted=wanted, stalled=stalled)
        (tmp_path / f"test_{name}.py").write_text(text)
    options = ["-v", "-p", "no:cacheprovider", "-c", "/dev/null"]
    words = [sys.executable, "-m", "pytest", *options, tmp_path]
    here = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])}
    text = subprocess.run(words, capture_output=True, text=True, check=False, env=here).stdout
    for name, (*_, outcome) in CASES.items():
        assert re.search(rf"test_{name}\.py::test_one .*{outcome}", text), text
    assert len(re.findall(r"run again \(\d left\)", text)) == 4  # of third and fourth
