# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Golden traces: every session of :mod:`support.golden_sessions` gives the numbers it gave when it
was recorded, at 1e-12 (those named there as sensitive: at 1e-11 to 1e-9). A difference that a
mended defect explains is recorded anew: ``python test/support/golden.py --write NAME``.
"""

import numpy as np
import pytest
from support.golden import FOLDER, Record, Signal, differences, stored_differences
from support.golden_sessions import MAPPINGS


@pytest.mark.parametrize("name", MAPPINGS)
def test_a_session_gives_the_stored_traces(name):
    found = stored_differences(name)
    assert not found, f"{name}: {len(found)} differ\n" + "\n".join(found[:5])


def test_every_stored_session_is_run():
    assert {file.stem for file in FOLDER.glob("*.npz")} == set(MAPPINGS)


def record(rows, column=0.0):
    """A session with one signal, of which rows 0 and 2 are kept."""
    values = np.array([[1.0], [rows], [4.0 + column]])
    sums = np.array([values.sum(), (values**2).sum(), 0.0, np.abs(values).max()])
    return Record({"f": Signal(np.array([0, 2]), values[[0, 2]], 3, sums)}, {"n": 1})


def test_a_row_that_is_kept_is_told_and_one_between_two_of_them_is_seen_in_the_sums():
    (words,) = differences(record(2.0), record(2.0, column=1e-9))
    assert words.startswith("f: row 2 of 3, column 0: ")
    (words,) = differences(record(2.0), record(2.0 + 1e-10))
    assert "sum over all rows" in words
    assert not differences(record(2.0), record(2.0 + 1e-13))
