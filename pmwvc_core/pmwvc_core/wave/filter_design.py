# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From the parameters of filters to their coefficients (App. A, B, E), and the frequency response.

A cut-off can be given in several ways; here each becomes a pole or second-order sections, arrays
``(sections, 6)`` of ``b0 b1 b2 1 a1 a2``. The filters that run are in
:mod:`pmwvc_core.law.wave.filter_and_hold`.

Butterworth filters are in closed form. The analogue prototype of order n has its poles at s_i =
exp(j pi (2 i + n + 1)/(2 n)), i = 0 ... n - 1. Low-pass: w_c s_i, no zeros; high-pass: w_c / s_i
and n zeros at rest. Bilinear transform: z = (2/T + s)/(2/T - s), which puts the zeros at z = -1
(low-pass) or z = 1 (high-pass). Each section has unit gain in its pass band; the least damped one
comes last. These are the designs of ``scipy.signal.buttord`` and ``butter`` (tested against them),
whose import takes seconds. Equations: docs/theory.md 2.2, 2.3, 2.4, 8.5.
"""

import functools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Array, Complex
from pmwvc_core.params import BankParams, FilterParams

DEFAULT_POLE_RAD_S = 50.0  # the filter of App. B
HIGHEST_ORDER = 20


def pole_of(params: FilterParams) -> float:
    """Return the pole a [rad/s] of a first-order filter a/(s + a), whichever way it is given.

    From |H|^2 = a^2/(a^2 + w^2): half the power (-3 dB) at w = a; a hundredth (-20 dB) at
    w = a sqrt(99).
    """
    if params.cutoff_hz is not None:
        return 2.0 * math.pi * params.cutoff_hz
    if params.stop_hz is not None:
        return 2.0 * math.pi * params.stop_hz / math.sqrt(99.0)
    return DEFAULT_POLE_RAD_S if params.pole_rad_s is None else params.pole_rad_s


def least_order(
    pass_hz: float, pass_db: float, stop_hz: float, stop_db: float, *,
    warp_s: float | None = None, prefix: str = "",
) -> int:  # fmt: skip
    """Return the least order of a Butterworth filter, low-pass or high-pass, with both losses: of
    the analogue one, or of the bilinear one at a tick ``warp_s`` [s].

    ParameterError, with ``prefix`` before its parameters, where the edges are so close that the
    filter would not compute well.
    """
    edges = [hz if warp_s is None else warped_rad_s(hz, warp_s) for hz in (pass_hz, stop_hz)]
    ratio = (10.0 ** (0.1 * stop_db) - 1.0) / (10.0 ** (0.1 * pass_db) - 1.0)
    order = math.ceil(math.log10(ratio) / (2.0 * math.log10(max(edges) / min(edges))))
    if order > HIGHEST_ORDER:
        raise ParameterError(
            f"{prefix}stop_hz = {stop_hz}: a Butterworth filter between {pass_db} dB at "
            f"{pass_hz} Hz and {stop_db} dB there is of order {order}, more than "
            f"{HIGHEST_ORDER}; move the edges apart"
        )
    return order


def order_of(params: FilterParams, *, tick_s: float) -> int:
    """Return the least order of an anti-aliasing filter with the attenuations asked for: of the
    sampled one, or with a stop edge at or above half the tick rate of the analogue one.
    """
    assert params.stop_hz is not None  # a Butterworth filter has one
    warp_s = tick_s if params.stop_hz * tick_s < 0.5 else None
    losses = params.pass_hz, params.pass_db, params.stop_hz, params.stop_db
    return least_order(*losses, warp_s=warp_s)


def warped_rad_s(edge_hz: float, tick_s: float) -> float:
    """Return where an analogue filter needs its edge for the bilinear one to have it there."""
    return 2.0 / tick_s * math.tan(math.pi * edge_hz * tick_s)


def _cutoff_rad_s(edge_rad_s: float, loss_db: float, order: int, side: str = "low") -> float:
    """Return the -3 dB frequency [rad/s] of an analogue filter with a loss at its edge."""
    ratio = (10.0 ** (0.1 * loss_db) - 1.0) ** (0.5 / order)  # of edge and cut-off
    return float(edge_rad_s / ratio if side == "low" else edge_rad_s * ratio)


def bilinear_sections(order: int, cutoff_rad_s: float, tick_s: float, side: str = "low") -> Array:
    """Return the sections of the filter by the bilinear transform, from order and -3 dB frequency
    of the analogue one; ``side`` (``low`` or ``high``) is what passes.
    """
    poles = 0.5 * tick_s * _analogue_poles(order, cutoff_rad_s, side)
    return _sections((1.0 + poles) / (1.0 - poles), -1.0 if side == "low" else 1.0)


def _analogue_poles(order: int, cutoff_rad_s: float, side: str) -> NDArray[np.complex128]:
    """Return the poles [rad/s] with positive imaginary part, best damped first; of an odd order
    the real one is among them.
    """
    angle = np.pi * (2.0 * np.arange(order) + order + 1.0) / (2.0 * order)
    unit = np.exp(1j * angle[: (order + 1) // 2])[::-1]
    if order % 2:
        unit[0] = -1.0
    return np.asarray(cutoff_rad_s * unit if side == "low" else cutoff_rad_s / unit.conj())


def _sections(poles: NDArray[np.complex128], zero: float) -> Array:
    """Return sections with these poles, all zeros at one place, and unit gain opposite to it."""
    sos, signs = [], np.array([1.0, -1.0, 1.0]) if zero == 1.0 else np.ones(3)
    for pole in poles:
        above = np.array([1.0, -2.0 * zero, 1.0])
        below = np.array([1.0, -2.0 * pole.real, abs(pole) ** 2])
        if pole.imag == 0.0:
            above, below = np.array([1.0, 0.5 * above[1], 0.0]), np.array([1.0, -pole.real, 0.0])
        sos.append(np.concatenate([above * (signs @ below) / (signs @ above), below]))
    return np.array(sos)


def half_power_hz(params: FilterParams, *, tick_s: float) -> float:
    """Return the -3 dB frequency [Hz]: of the first order that of the analogue filter, of a
    Butterworth filter that of the sampled one; infinite for others, which have no such parameter.
    """
    if params.kind == "first_order":
        return pole_of(params) / (2.0 * math.pi)
    if params.kind != "butterworth":
        return math.inf
    return math.atan(_analogue_cutoff_rad_s(params, tick_s) * tick_s / 2.0) / (math.pi * tick_s)


def design(params: FilterParams, *, tick_s: float) -> Array:
    """Return the sections of an anti-aliasing filter.

    First order: exact under a held input, y+ = p y + (1-p) u with p = exp(-a T_c).

    Butterworth: the least order that has both attenuations (:func:`order_of`), scaled so that the
    edge named by ``meet`` is met exactly, which leaves something over at the other one. It is
    pre-warped at that edge, so the sampled filter meets it. ParameterError where an edge is to be
    met that is not below half the tick rate.
    """
    if params.kind == "first_order":
        p = math.exp(-pole_of(params) * tick_s)
        return np.array([[1.0 - p, 0.0, 0.0, 1.0, -p, 0.0]])
    if params.kind != "butterworth":
        return np.array([[1.0, 0.0, 0.0, 1.0, 0.0, 0.0]])  # changes nothing
    cutoff, order = _analogue_cutoff_rad_s(params, tick_s), order_of(params, tick_s=tick_s)
    return bilinear_sections(order, cutoff, tick_s)


def _analogue_cutoff_rad_s(params: FilterParams, tick_s: float) -> float:
    """Return the -3 dB frequency of the analogue prototype [rad/s]."""
    edge_hz, loss_db = params.pass_hz, params.pass_db
    if params.meet == "stop" and params.stop_hz is not None:
        edge_hz, loss_db = params.stop_hz, params.stop_db
    if edge_hz * tick_s >= 0.5:
        raise ParameterError(
            f"{params.meet}_hz = {edge_hz}: must be < {0.5 / tick_s:g} Hz, half the tick "
            f"rate, to be met; meet the other edge"
        )
    edge = warped_rad_s(edge_hz, tick_s)
    return _cutoff_rad_s(edge, loss_db, order_of(params, tick_s=tick_s))


def response(
    params: FilterParams, frequency_hz: Array, *, tick_s: float, rate_drop: int
) -> Complex:
    """Return the frequency response of an anti-aliasing filter at the tick rate;
    ``integrate_and_dump`` counts as the moving mean over the M ticks of a frame.
    """
    omega = 2.0 * np.pi * np.asarray(frequency_hz, dtype=float) * tick_s
    if params.means:
        ages = np.multiply.outer(omega, np.arange(rate_drop))
        return np.asarray(np.exp(-1j * ages).mean(axis=-1))
    return sections_response(design(params, tick_s=tick_s), omega)


def sections_response(sos: Array, angle: Array) -> Complex:
    """Return the response of second-order sections ``(sections, 6)`` at angles [rad per tick].

    A factor (1 - 1/z) of a numerator or denominator is formed as such, so that it keeps its
    relative accuracy near rest.
    """
    delay = np.exp(-1j * np.asarray(angle, dtype=float))
    rest = 2j * np.sin(0.5 * angle) * np.exp(-0.5j * np.asarray(angle))  # 1 - 1/z
    found: Complex = np.ones_like(delay)
    for b0, b1, b2, a0, a1, a2 in sos:
        # c0 + c1 d + c2 d^2 = (c0 + c1 + c2) - (c1 + c2 (1 + d)) (1 - d)
        above = (b0 + b1 + b2) - (b1 + b2 * (1.0 + delay)) * rest
        below = (a0 + a1 + a2) - (a1 + a2 * (1.0 + delay)) * rest
        found = found * above / below
    return found


class BankSections(NamedTuple):
    """Sections ``(sections, 6)`` of the filters of a bank; None: a wire."""

    low_up: Array | None  # of the wave to the server
    low_down: Array | None  # of the wave from the server
    high_up: Array  # of the wave to the local model
    high_down: Array  # of the wave from the local model


def bank_filters(params: BankParams, *, tick_s: float) -> BankSections:
    """Return the filters of a bank that splits a wave in two and puts two together; ParameterError
    where an edge is not below half the tick rate, or two are too close together.

    ``dissertation`` (E Table 1): a high pass HP on the way to the local model and a low pass LP2
    on the way back; the low branch goes on as it is. The amplitudes of the table are attenuations:
    HP has 40 dB at 40 Hz and 20 dB at 70 Hz, LP2 1 dB at 300 Hz and 40 dB at 600 Hz. 600 Hz lies
    above half the tick rate, so the order is the least *analogue* one (HP 5, LP2 8); the loss of
    the pass band is met exactly by the sampled filter.

    ``complementary``: H1 = a/(s + a) and H2 = s/(s + a), split and put together by the same two,
    v = H1 v1 + H2 v2. |H1|^2 + |H2|^2 = 1, also sampled: neither makes energy.
    """
    if params.kind == "complementary":
        a = params.split_rad_s
        low, high = (bilinear_sections(1, a, tick_s, side) for side in ("low", "high"))
        return BankSections(low, low, high, high)
    high, low = (_bank_butterworth(params, side, tick_s) for side in ("high", "low"))
    return BankSections(None, None, high, low)


@functools.lru_cache(maxsize=512)
def _bank_butterworth(params: BankParams, side: str, tick_s: float) -> Array:
    """Return the sections of a filter; not to be written to."""
    names = ("pass_hz", "pass_db", "stop_hz", "stop_db")
    pass_hz, pass_db, stop_hz, stop_db = (getattr(params, f"{side}_{name}") for name in names)
    if pass_hz * tick_s >= 0.5:
        raise ParameterError(
            f"bank.{side}_pass_hz = {pass_hz}: must be < {0.5 / tick_s:g} Hz, half the tick rate"
        )
    order = least_order(pass_hz, pass_db, stop_hz, stop_db, prefix=f"bank.{side}_")
    cutoff = _cutoff_rad_s(warped_rad_s(pass_hz, tick_s), pass_db, order, side)
    return bilinear_sections(order, cutoff, tick_s, side)
