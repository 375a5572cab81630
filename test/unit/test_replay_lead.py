# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sentence that says how far a replay is from its recording, from which tick on, and why."""

from types import SimpleNamespace

import pytest

from pmwvc_analysis.replay.run import Inexact
from pmwvc_bringup.commands.compare import lead


def user(force, first=None, **others):
    found = {
        "name": "user1",
        "ticks": 900,
        "missing": 0,
        "force_max_n": force,
        "position_max_m": force,
    }
    found |= {"first_tick": first, "first_s": first and first * 1e-3}
    found |= {"first_signals": ["x_m", "v_m"] if first else []}
    return found | others


LOST = Inexact(0.5, "user1: 3 blocks of its trace were not recorded")
LATER = Inexact(0.8, "the server was started again")
CASES = [
    ([user(0.0)], True, "is exact: force and position of all 900 ticks of user1 are equal."),
    ([user(0.0, missing=24)], True, "not exact: forces differ by up to 0 N; 24 ticks of"),
    ([user(0.02, 510)], True, "differ by up to 0.02 N, from tick 510 of user1"),
    ([user(0.21, 510)], False, "on (0.510 s; x_m, v_m). Why: user1: 3 blocks of its trace"),
    ([user(0.21, 410)], False, "on (0.410 s; x_m, v_m). The recording gives no reason."),
    ([user(0.0), user(None)], False, "does NOT reproduce the recording: not all forces can be"),
    ([], False, "does NOT reproduce the recording: not all forces can be compared."),
    ([user(0.0), user(1.5)], None, "Replayed with master.impedance = 40: forces differ by"),
]  # fmt: skip


@pytest.mark.parametrize(("found", "same", "said"), CASES)
def test_only_a_replay_whose_every_tick_was_compared_is_exact(found, same, said):
    changes = {"master.impedance": 40}
    result = SimpleNamespace(differences=found, changes=changes, limits=[LOST, LATER])
    text = lead(result, same)
    assert said in text
    assert ("is exact" in text) == (said == CASES[0][2])
    assert LATER.why not in text or "cannot be compared" in text
