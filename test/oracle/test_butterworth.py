# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Butterworth filters from an attenuation table against a digital design by scipy."""

import numpy as np
import pytest
from scipy import signal
from support.strategies import TICK_S

from pmwvc_core.params import FilterParams
from pmwvc_core.wave.filter_design import design, order_of


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
    assert order_of(params, tick_s=TICK_S) == order
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


@pytest.mark.parametrize(
    ("edges", "order"), [((150, 200), 7), ((200, 250), 8), ((250, 300), 8), ((25, 50), 4)]
)
def test_the_order_is_the_least_of_the_sampled_filter(edges, order):
    """The edges of App. A, Table 2. The control is the analogue order, which is larger: the
    bilinear transform moves high edges apart.
    """
    low, high = edges
    params = FilterParams(kind="butterworth", pass_hz=low, stop_hz=high, pass_db=20, stop_db=40)
    expected, _ = signal.buttord(low, high, 20, 40, fs=1 / TICK_S)
    analogue, _ = signal.buttord(low, high, 20, 40, analog=True)
    assert order_of(params, tick_s=TICK_S) == expected == order
    assert analogue > order or low == 25
    found = abs(signal.sosfreqz(design(params, tick_s=TICK_S), [2 * np.pi * high * TICK_S])[1])
    assert -20.0 * np.log10(found[0]) >= 40.0 - 1e-9


def test_a_stop_edge_beyond_half_the_tick_rate_sets_the_analogue_order():
    params = FilterParams(kind="butterworth", pass_hz=300, stop_hz=600, pass_db=1, stop_db=40)
    assert order_of(params, tick_s=TICK_S) == 8
