# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Values that hypothesis draws in more than one test."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pmwvc_core.params import MasterParams
from pmwvc_core.wave.impedance import MatrixImpedance

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


@st.composite
def matrices(draw, dof=None):
    """Draw matrix impedances of 2 to 6 axes: eigenvalues 0.5 to 500 N s/m, any principal axes."""
    size = dof or draw(st.integers(2, 6))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    axes, _ = np.linalg.qr(rng.normal(size=(size, size)))
    return MatrixImpedance(np.sort(np.exp(rng.uniform(np.log(0.5), np.log(500.0), size))), axes)


def text_of(matrix):
    """Return a matrix as a parameter has it."""
    return "; ".join(" ".join(repr(float(entry)) for entry in row) for row in matrix)


def behind(b, **names):
    """Return the parameters of a master behind a number or a matrix."""
    if isinstance(b, MatrixImpedance):
        return MasterParams(impedance_matrix=text_of(b.matrix), **names)
    return MasterParams(impedance=b, **names)


def signals_of(count):
    """Draw a function that makes ``count`` signals for an impedance, single or of three runs; of
    three axes behind a number.
    """

    def function(seed_and_runs):
        rng, runs = np.random.default_rng(seed_and_runs[0]), seed_and_runs[1]
        return lambda b: [
            rng.normal(size=(*runs, len(getattr(b, "values", "xyz")))) for _ in range(count)
        ]

    return st.tuples(st.integers(0, 2**32 - 1), st.sampled_from([(), (3,)])).map(function)


def power(u, v):
    """Return the power that runs towards the server, (|u|^2 - |v|^2)/2 [W], one per run."""
    u, v = (np.sum(np.square(np.atleast_1d(wave)), -1, keepdims=True) for wave in (u, v))
    return (u - v) / 2
