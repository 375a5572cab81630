# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The filters of a bank that splits a wave in two and puts two waves together (App. E).

``dissertation`` (E Table 1): a high pass HP on the way to the local model and a low pass LP2 on
the way back; the low branch goes on as it is, to the anti-aliasing filter LP1 of the packets. The
amplitudes of the table are attenuations, as in App. A, and a high pass stops below: HP has 40 dB
at 40 Hz and 20 dB at 70 Hz, LP2 has 1 dB at 300 Hz and 40 dB at 600 Hz. 600 Hz lies above half
the tick rate, so the order is the least *analogue* Butterworth order (HP 5, LP2 8); the loss
of the pass band is met exactly by the sampled filter (bilinear, pre-warped at its edge).

``complementary``: H1 = a/(s + a) and H2 = s/(s + a), split and put together by the same two,
v = H1 v1 + H2 v2. |H1|^2 + |H2|^2 = 1, which the bilinear transform keeps, so the split neither
makes nor takes energy and putting together makes none.

Equations: docs/theory.md 8.5.
"""

import functools
from typing import NamedTuple

import numpy as np

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Array
from pmwvc_core.params import BankParams
from pmwvc_core.wave.design.filter_design import bilinear_sections, least_order, warped_rad_s


class BankFilters(NamedTuple):
    """Second-order sections ``(sections, 6)``; None: a wire."""

    low_up: Array | None  # of the wave to the server
    high_up: Array  # of the wave to the local model
    low_down: Array | None  # of the wave from the server
    high_down: Array  # of the wave from the local model


def bank_filters(params: BankParams, *, tick_s: float) -> BankFilters:
    """Return the filters of the bank ``params.kind`` names; ParameterError where an edge is not
    below half the tick rate, or two are too close together.
    """
    if params.kind == "complementary":
        c = params.split_rad_s * (0.5 * tick_s)  # bilinear, a = split_rad_s
        pole = (c - 1.0) / (1.0 + c)
        low = np.array([[c / (1.0 + c), c / (1.0 + c), 0.0, 1.0, pole, 0.0]])
        high = np.array([[1.0 / (1.0 + c), -1.0 / (1.0 + c), 0.0, 1.0, pole, 0.0]])
        return BankFilters(low, high, low, high)
    high, low = (_butterworth(params, side, tick_s) for side in ("high", "low"))
    return BankFilters(None, high, None, low)


@functools.lru_cache(maxsize=512)
def _butterworth(params: BankParams, side: str, tick_s: float) -> Array:
    """Return the sections of a filter; not to be written to."""
    names = ("pass_hz", "pass_db", "stop_hz", "stop_db")
    pass_hz, pass_db, stop_hz, stop_db = (getattr(params, f"{side}_{name}") for name in names)
    if pass_hz * tick_s >= 0.5:
        raise ParameterError(
            f"bank.{side}_pass_hz = {pass_hz}: must be < {0.5 / tick_s:g} Hz, half the tick rate"
        )
    order = least_order(pass_hz, pass_db, stop_hz, stop_db, prefix=f"bank.{side}_")
    edge = warped_rad_s(pass_hz, tick_s)
    ratio = (10.0 ** (0.1 * pass_db) - 1.0) ** (0.5 / order)  # of edge and cut-off
    cutoff = edge / ratio if side == "low" else edge * ratio
    return bilinear_sections(order, cutoff, tick_s, side)
