# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Values that hypothesis draws in more than one test."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

TICK_S = 0.001

impedances = st.floats(0.1, 1000.0)
rate_drops = st.integers(1, 24)
poles_rad_s = st.floats(0.5, 2000.0)
# Amplitudes that neither vanish nor overflow when squared.
amplitudes = st.one_of(st.just(0.0), st.floats(1e-3, 1e3), st.floats(-1e3, -1e-3))


def signals(*, shortest=1, longest=200, dof=None):
    """Draw arrays ``(ticks,)``, or ``(ticks, dof)``."""
    ticks = st.integers(shortest, longest)
    shapes = ticks if dof is None else ticks.map(lambda n: (n, dof))
    return hnp.arrays(np.float64, shapes, elements=amplitudes)
