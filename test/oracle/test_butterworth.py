# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Butterworth filters against scipy's design."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import signal
from strategies import TICK_S

from pmwvc_core.params import FilterParams
from pmwvc_core.wave import design
from pmwvc_core.wave.filter_design import HIGHEST_ORDER, order_of


@given(
    pass_hz=st.floats(5.0, 200.0),
    wider=st.floats(1.2, 5.0),
    pass_db=st.floats(0.5, 20.0),
    more_db=st.floats(3.0, 40.0),
)
def test_the_order_is_the_least_that_has_both_attenuations(pass_hz, wider, pass_db, more_db):
    edges = pass_hz, wider * pass_hz
    losses = pass_db, pass_db + more_db
    expected, _ = signal.buttord(*edges, *losses, analog=True)
    assume(expected <= HIGHEST_ORDER)
    params = FilterParams(
        kind="butterworth",
        pass_hz=edges[0],
        stop_hz=edges[1],
        pass_db=losses[0],
        stop_db=losses[1],
    )
    assert order_of(params) == expected


@pytest.mark.parametrize("meet", ["pass", "stop"])
@pytest.mark.parametrize(
    ("edges", "losses", "order"),
    [
        ((25, 50), (20, 40), 4),
        ((10, 25), (20, 40), 3),
        ((20, 200), (3, 20), 1),
        ((100, 150), (20, 40), 6),
    ],
)
def test_the_bilinear_filter_is_scipys(meet, edges, losses, order):
    params = FilterParams(
        kind="butterworth",
        pass_hz=edges[0],
        stop_hz=edges[1],
        pass_db=losses[0],
        stop_db=losses[1],
        meet=meet,
    )
    assert order_of(params) == order
    place = meet == "stop"
    loss = 10.0 ** (0.1 * losses[place]) - 1.0
    warped = np.tan(np.pi * edges[place] * TICK_S) / loss ** (0.5 / order)
    expected = signal.butter(
        order, np.arctan(warped) / np.pi / TICK_S, fs=1 / TICK_S, output="sos"
    )
    angles = np.linspace(0.0, 3.1, 200)
    ours, scipys = (
        signal.sosfreqz(sos, angles)[1] for sos in (design(params, tick_s=TICK_S), expected)
    )
    np.testing.assert_allclose(ours, scipys, atol=1e-12)
