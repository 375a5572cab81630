# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A filter bank in the waves of a port returns no more energy than it received, whatever passive
thing is behind it; where a margin is missing, it returns more.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.filter_runs import BUTTERWORTH
from support.port_parts import STILL, Echo, Waves
from support.strategies import signals

from pmwvc_core.params import BankParams, LocalModelParams, MasterParams

LOW_REACHING = {
    "high_pass_hz": 4.0,
    "high_pass_db": 3.0,
    "high_stop_hz": 0.4,
    "high_stop_db": 20.0,
}
reflections = st.one_of(st.sampled_from([-1.0, 1.0]), st.floats(-1.0, 1.0))


def bank(matrix="", stiffness=0.0, damping=0.0, acts="everywhere", **values):
    return MasterParams(
        impedance_matrix=matrix,
        bank=BankParams(**values),
        local_model=LocalModelParams(stiffness=stiffness, damping=damping, acts=acts),
    )


@given(
    waves=signals(longest=120),
    pole=st.floats(0.1, 2000.0),
    stiffness=st.floats(0.0, 1e6),
    damping=st.one_of(st.just(0.0), st.floats(0.0, 1e4)),
    delay=st.integers(1, 30),
    reflections=st.lists(reflections, min_size=1, max_size=20),
    touching=st.lists(st.booleans(), min_size=1, max_size=7),
)
def test_the_complementary_bank_gives_out_no_more_than_it_got_at_any_tick(
    waves, pole, stiffness, damping, delay, reflections, touching
):
    """Whatever passive server and local model: here both change as they like."""
    params = bank("", stiffness, damping, "above", kind="complementary", split_rad_s=pole)
    places = [1.0 if there else -1.0 for there in touching]
    found = Waves(params, Echo(delay, reflections)).run(waves.tolist(), places)
    assert found.least >= -1e-9 * found.out


@pytest.mark.parametrize("matrix", ["", "30 2 0; 2 20 1; 0 1 25"])
@given(waves=signals(longest=60, dof=3), pole=st.floats(0.1, 2000.0), k=st.floats(0.0, 1e6))
def test_the_local_model_stores_and_turns_to_heat_what_its_port_gets(matrix, waves, pole, k):
    params = bank(matrix, k, 2.0, kind="complementary", split_rad_s=pole)
    found = Waves(params, Echo(1, [1.0]), axes=3).run(waves).part.energies
    taken = found["bank_high_in"] - found["bank_high_out"]
    kept = found["local_stored"] + found["local_dissipated"]
    assert abs(taken - kept) <= 1e-9 * (found["bank_high_in"] + 1e-12)
    assert found["local_stored"] >= 0.0


def most_given(params, waves, delay=1, sign=1.0, places=STILL):
    """Return the most that the dissertation's arrangement gives out, over what went in."""
    found = Waves(params, Echo(delay, [sign]), BUTTERWORTH).run(waves, places)
    return -found.least / found.out


def test_control_a_dissertation_bank_that_reaches_down_gives_out_more_than_it_got():
    """|LP1| + |LP2| |HP| is 1.90 at 9.4 Hz: a delay that turns the server's answer into the phase
    of the local model's finds it. With the same environment the complementary pair is passive.
    """
    waves = np.sin(2.0 * np.pi * 9.4e-3 * np.arange(700)).tolist()
    assert most_given(bank(kind="dissertation", **LOW_REACHING), waves, 13, -1.0) > 2.0
    params = bank(kind="complementary", split_rad_s=25.0)
    assert most_given(params, waves, 13, -1.0) <= 1e-9


def test_control_a_local_model_that_opens_and_closes_makes_table_1_active():
    """With the filters of Table 1 |LP1| + |LP2| |HP| stays within 1e-12 of 1, so no linear
    environment makes the bank active by more. A contact that opens and closes at the frequency of
    the wave turns it into a steady one, in phase with the server's.
    """
    waves = (0.7 + np.cos(2.0 * np.pi * 0.2 * np.arange(400))).tolist()
    places = [-1.0, 1.0, 1.0, -1.0, -1.0]
    local = {"damping": 1e4, "acts": "above"}
    assert most_given(bank(kind="dissertation", **local), waves, places=places) > 0.2
    params = bank(kind="complementary", split_rad_s=100.0, **local)
    assert most_given(params, waves, places=places) <= 1e-9
