# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Golden traces: every session of :mod:`support.golden_sessions` gives the numbers it gave when it
was recorded, at 1e-12 (those named there as sensitive: at 1e-11 to 1e-9). A difference that a
mended defect explains is recorded anew: ``python test/support/golden.py NAME``.

All were recorded step by step. Of the two numbers of axes of a session one is stepped again, the
other run by the loop of many sessions, with the laws as they are written.
"""

import numpy as np
import pytest
from support import golden
from support.golden import FOLDER, Record, Signal, differences
from support.golden_sessions import MAPPINGS

from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.bulk.run import can_run, run, session
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.simulation.traces import traces_of

AXES = {"plain": "1", "strict": "3"}  # in bulk; without waves three


@pytest.mark.parametrize("name", MAPPINGS)
def test_a_session_gives_the_stored_traces(name):
    scenario = parse_scenario(MAPPINGS[name])
    if name[-1] == AXES.get(name.rsplit("_", 2)[-2], "3") and can_run(scenario):
        left = run(scenario, session)
        assert left.whole
        traces = traces_of(left)
    else:
        traces = simulate_one(scenario)
    was, now = golden.load(FOLDER / f"{name}.npz"), golden.record_of(traces)
    found = differences(was, now, golden.tolerance_of(name))
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
