# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Butterworth filters from an attenuation table against a digital design by scipy."""

import numpy as np
import pytest
from scipy import signal
from strategies import TICK_S

from pmwvc_core.params import FilterParams
from pmwvc_core.wave import design
from pmwvc_core.wave.filter_design import order_of


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
