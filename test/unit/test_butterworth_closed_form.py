# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Butterworth filters in closed form are those of scipy, without its import."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import signal

from pmwvc_core.errors import ParameterError
from pmwvc_core.wave.filter_design import HIGHEST_ORDER, bilinear_sections, least_order

TICK_S = 1e-3
ANGLES = np.linspace(0.0, 3.14, 400)


@pytest.mark.parametrize("side", ["low", "high"])
@pytest.mark.parametrize("order", range(1, 13))
@pytest.mark.parametrize("cutoff_hz", [7.0, 15.9, 60.0, 200.0, 450.0])
def test_bilinear_sections_respond_as_scipys(order, cutoff_hz, side):
    cutoff = 2.0 / TICK_S * np.tan(np.pi * cutoff_hz * TICK_S)
    ours = bilinear_sections(order, cutoff, TICK_S, side)
    theirs = signal.butter(order, cutoff_hz, side, fs=1.0 / TICK_S, output="sos")
    values = [signal.sosfreqz(sos, ANGLES)[1] for sos in (ours, theirs)]
    np.testing.assert_allclose(values[0], values[1], atol=1e-12)


@given(
    edges=st.tuples(st.floats(1.0, 400.0), st.floats(1.0, 400.0)),
    losses=st.tuples(st.floats(0.1, 80.0), st.floats(0.1, 80.0)),
)
def test_the_least_order_is_scipys(edges, losses):
    low, high = sorted(edges)
    little, much = sorted(losses)
    assume(high / low > 1.01 and much - little > 0.01)
    for pass_hz, stop_hz in ((low, high), (high, low)):
        expected, _ = signal.buttord(pass_hz, stop_hz, little, much, analog=True)
        if expected > HIGHEST_ORDER:
            with pytest.raises(ParameterError, match=f"is of order {expected:.0f},"):
                least_order(pass_hz, little, stop_hz, much)
        else:
            assert least_order(pass_hz, little, stop_hz, much) == expected


def test_filter_questions_do_not_import_scipys_signal_processing():
    program = (
        "import sys\n"
        "from pmwvc_core.params import FilterParams\n"
        "from pmwvc_core.wave.aliasing import delay_of, warnings_of, worst_case_gain\n"
        "one = FilterParams(kind='butterworth', pass_hz=25.0, stop_hz=50.0)\n"
        "for ask in (delay_of, warnings_of, worst_case_gain):\n"
        "    ask(one, tick_s=1e-3, rate_drop=8)\n"
        "print([name for name in sys.modules if name.split('.')[0] == 'scipy'])\n"
    )
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == "[]"
