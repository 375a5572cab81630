# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From the parameters of the anti-aliasing filter to its coefficients (App. A, App. B), and its
frequency response.

A cut-off can be given in several ways; here each becomes a pole or second-order sections. The
filter that runs is in :mod:`pmwvc_core.law.wave.filter_and_hold`.

Butterworth filters are in closed form: the analogue prototype of order n has its poles on the unit
circle of the left half-plane,

    s_i = exp(j pi (2 i + n + 1)/(2 n)),        i = 0 ... n - 1;

low-pass: w_c s_i, no zeros; high-pass: w_c / s_i and n zeros at rest. Bilinear transform:
z = (2/T + s)/(2/T - s), which puts the zeros at z = -1 (low-pass) or z = 1 (high-pass). Each
section has unit gain in its pass band; the least damped one comes last. These are the designs of
``scipy.signal.buttord`` and ``butter`` (tested against them), whose import takes seconds.

Equations: docs/theory.md 2.2, 2.3, 2.4.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Array, Complex
from pmwvc_core.params import FilterParams

DEFAULT_POLE_RAD_S = 50.0  # the filter of App. B
HIGHEST_ORDER = 20
PASS_THROUGH = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)  # a section that changes nothing


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


def order_of(params: FilterParams, *, tick_s: float) -> int:
    """Return the least order of a Butterworth filter with the attenuations asked for.

    ``bilinear``: the least order of the sampled filter, from both edges pre-warped. A stop edge at
    or above half the tick rate has no place there; then, and for ``matched``, it is the least
    order of the analogue filter. ParameterError where the edges are so close that the filter would
    not compute well.
    """
    assert params.stop_hz is not None  # a Butterworth filter has one
    pass_edge, stop_edge = params.pass_hz, params.stop_hz
    if params.warps and stop_edge * tick_s < 0.5:
        pass_edge, stop_edge = warped_rad_s(pass_edge, tick_s), warped_rad_s(stop_edge, tick_s)
    named = params.pass_hz, params.stop_hz
    return least_order(pass_edge, params.pass_db, stop_edge, params.stop_db, named=named)


def least_order(
    pass_hz: float, pass_db: float, stop_hz: float, stop_db: float, *,
    named: tuple[float, float] | None = None, prefix: str = "",
) -> int:  # fmt: skip
    """Return the least order of an analogue Butterworth filter, low-pass or high-pass, with both
    losses; ParameterError where the edges are so close that it would not compute well.

    What is raised names the edges, or those given as ``named`` where they are pre-warped, with
    ``prefix`` before their parameters.
    """
    ratio = (10.0 ** (0.1 * stop_db) - 1.0) / (10.0 ** (0.1 * pass_db) - 1.0)
    span = stop_hz / pass_hz if stop_hz > pass_hz else pass_hz / stop_hz
    order = math.ceil(math.log10(ratio) / (2.0 * math.log10(span)))
    if order > HIGHEST_ORDER:
        pass_hz, stop_hz = named or (pass_hz, stop_hz)
        raise ParameterError(
            f"{prefix}stop_hz = {stop_hz}: a Butterworth filter between {pass_db} dB at "
            f"{pass_hz} Hz and {stop_db} dB there is of order {order}, more than "
            f"{HIGHEST_ORDER}; move the edges apart"
        )
    return order


def bilinear_sections(order: int, cutoff_rad_s: float, tick_s: float, side: str = "low") -> Array:
    """Return ``b0 b1 b2 1 a1 a2`` per section of the filter by the bilinear transform, from order
    and -3 dB frequency of the analogue one; ``side`` (``low`` or ``high``) is what passes.
    """
    poles = 0.5 * tick_s * _analogue_poles(order, cutoff_rad_s, side)
    zero = -1.0 if side == "low" else 1.0
    return _sections((1.0 + poles) / (1.0 - poles), order, zero=zero)


def matched_sections(order: int, cutoff_rad_s: float, tick_s: float) -> Array:
    """Return the low-pass filter with the poles exp(s T), without zeros."""
    poles = _analogue_poles(order, cutoff_rad_s, "low")
    return _sections(np.exp(tick_s * poles), order, zero=None)


def _analogue_poles(order: int, cutoff_rad_s: float, side: str) -> NDArray[np.complex128]:
    """Return the poles [rad/s] with positive imaginary part, best damped first; of an odd order
    the real one is among them.
    """
    angle = np.pi * (2.0 * np.arange(order) + order + 1.0) / (2.0 * order)
    unit = np.exp(1j * angle[: (order + 1) // 2])[::-1]
    if order % 2:
        unit[0] = -1.0
    return np.asarray(cutoff_rad_s * unit if side == "low" else cutoff_rad_s / unit.conj())


def _sections(poles: NDArray[np.complex128], order: int, *, zero: float | None) -> Array:
    """Return sections with these poles, all zeros at one place, and unit gain opposite to it."""
    found = []
    for number, pole in enumerate(poles):
        if order % 2 and number == 0:
            below = np.array([1.0, -pole.real, 0.0])
            above = np.array([1.0, 0.0 if zero is None else -zero, 0.0])
        else:
            below = np.array([1.0, -2.0 * pole.real, abs(pole) ** 2])
            above = np.array([1.0, 0.0, 0.0] if zero is None else [1.0, -2.0 * zero, 1.0])
        signs = np.ones(3) if zero != 1.0 else np.array([1.0, -1.0, 1.0])
        found.append(np.concatenate([above * (signs @ below) / (signs @ above), below]))
    return np.array(found)


def half_power_hz(params: FilterParams, *, tick_s: float) -> float:
    """Return the -3 dB frequency [Hz] of a filter that has one.

    Of the first order that of the analogue filter, of a Butterworth filter that of the sampled
    one; infinite for ``none`` and ``integrate_and_dump``, which have no such parameter.
    """
    if params.kind == "first_order":
        return pole_of(params) / (2.0 * math.pi)
    if params.kind != "butterworth":
        return math.inf
    cutoff = _analogue_cutoff_rad_s(params, tick_s)
    if params.warps:
        return math.atan(cutoff * tick_s / 2.0) / (math.pi * tick_s)
    return cutoff / (2.0 * math.pi)


def design(params: FilterParams, *, tick_s: float) -> Array:
    """Return the filter as second-order sections ``b0 b1 b2 1 a1 a2``, ``(sections, 6)``.

    First order: exact under a held input, y+ = p y + (1-p) u with p = exp(-a T_c).

    Butterworth: the least order that has both attenuations (:func:`order_of`), scaled so that the
    edge named by ``meet`` is met exactly, which leaves something over at the other one.
    ``bilinear`` is pre-warped at that edge, so the sampled filter meets it; ``matched`` maps the
    analogue poles by z = exp(s T_c), without zeros and with unit gain at rest, so it is the
    analogue filter that meets it. ParameterError where ``bilinear`` is to meet an edge that is not
    below half the tick rate.
    """
    if params.kind == "first_order":
        p = math.exp(-pole_of(params) * tick_s)
        return np.array([[1.0 - p, 0.0, 0.0, 1.0, -p, 0.0]])
    if params.kind != "butterworth":
        return np.array([PASS_THROUGH])
    cutoff, order = _analogue_cutoff_rad_s(params, tick_s), order_of(params, tick_s=tick_s)
    sections = bilinear_sections if params.warps else matched_sections
    return sections(order, cutoff, tick_s)


def warped_rad_s(edge_hz: float, tick_s: float) -> float:
    """Return where an analogue filter needs its edge for the bilinear one to have it there."""
    return 2.0 / tick_s * math.tan(math.pi * edge_hz * tick_s)


def _analogue_cutoff_rad_s(params: FilterParams, tick_s: float) -> float:
    """Return the -3 dB frequency of the analogue prototype [rad/s]."""
    edge_hz, loss_db = (params.pass_hz, params.pass_db)
    if params.meet == "stop" and params.stop_hz is not None:
        edge_hz, loss_db = (params.stop_hz, params.stop_db)
    edge = 2.0 * math.pi * edge_hz
    if params.warps:
        if edge_hz * tick_s >= 0.5:
            raise ParameterError(
                f"{params.meet}_hz = {edge_hz}: must be < {0.5 / tick_s:g} Hz, half the tick "
                f"rate, to be met by a bilinear filter; meet the other edge, or use matched"
            )
        edge = warped_rad_s(edge_hz, tick_s)
    loss = 10.0 ** (0.1 * loss_db) - 1.0  # (w/w_c)^2n at the edge
    return float(edge / loss ** (0.5 / order_of(params, tick_s=tick_s)))


def response(
    params: FilterParams, frequency_hz: Array, *, tick_s: float, rate_drop: int
) -> Complex:
    """Return the frequency response of an anti-aliasing filter at the tick rate.

    ``integrate_and_dump`` counts as the moving mean over M ticks whose last value in a frame the
    packet is.
    """
    omega = 2.0 * np.pi * np.asarray(frequency_hz, dtype=float) * tick_s
    if params.means:
        ages = np.arange(rate_drop)
        mean: Complex = np.exp(-1j * np.multiply.outer(omega, ages)).mean(axis=-1)
        return mean
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
