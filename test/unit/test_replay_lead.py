# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The sentence that says how far a replay is from its recording."""

from types import SimpleNamespace

import pytest

from pmwvc_bringup.commands.session.replay import lead


@pytest.mark.parametrize(("forces", "same", "said"), [
    ([0.0, 0.0], True, "reproduces the recording: the forces are equal."),
    ([0.0, 0.21], False, "does NOT reproduce the recording: forces differ by up to 0.21 N."),
    ([0.0, None], False, "does NOT reproduce the recording: not all forces can be compared."),
    ([], False, "does NOT reproduce the recording: not all forces can be compared."),
    ([0.0, 1.5], None, "Replayed with master.impedance = 40: forces differ by up to 1.5 N."),
])  # fmt: skip
def test_a_force_that_cannot_be_compared_is_no_difference_of_zero(forces, same, said):
    differences = [{"force_max_n": force} for force in forces]
    result = SimpleNamespace(differences=differences, changes={"master.impedance": 40})
    assert said in lead(result, same)
