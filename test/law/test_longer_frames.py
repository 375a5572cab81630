# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Integrate-and-dump over frames that are not M ticks long: it never sends more than came in."""

import pytest

from pmwvc_core.law.wave.filter_and_hold import filter_sample, filter_step, made_filter
from pmwvc_core.params import FilterParams

M = 8


@pytest.mark.parametrize(("ticks", "sent"), [(6, 6 / 8), (8, 1.0), (9, 1.0), (13, 1.0)])
def test_a_frame_is_divided_by_m_or_by_its_own_ticks_if_it_has_more(ticks, sent):
    params = FilterParams(kind="integrate_and_dump")
    s, p = made_filter(params, 1, 0.001, M)
    for _ in range(2):  # the second frame knows nothing of the first
        for _ in range(ticks):
            s, _ = filter_step(s, (1.0,), p)
        s, wave = filter_sample(s, p)
        assert wave == pytest.approx((sent,), rel=1e-15)
        assert wave[0] ** 2 * max(M, ticks) <= ticks + 1e-12  # Cauchy-Schwarz
