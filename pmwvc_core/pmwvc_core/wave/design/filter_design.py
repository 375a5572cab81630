# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From the parameters of the anti-aliasing filter to its coefficients (App. A, App. B).

A cut-off can be given in several ways; here each becomes a pole or second-order sections. The
filter that runs is in :mod:`pmwvc_core.law.wave.anti_aliasing`.

Equations: docs/theory.md 2.2.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Array, Value, exponential
from pmwvc_core.params import FilterParams, Validated, specs
from pmwvc_core.wave.design import butterworth

P = TypeVar("P", bound=Validated)
DEFAULT_POLE_RAD_S = 50.0  # the filter of App. B
HIGHEST_ORDER = 20
PASS_THROUGH = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)  # a section that changes nothing


def pole_of(params: FilterParams) -> Value:
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
    order = butterworth.least_order(pass_edge, params.pass_db, stop_edge, params.stop_db)
    edges = (params.pass_hz, params.pass_db, params.stop_hz, params.stop_db)
    return _computable(order, *edges, prefix="")


def least_order(
    pass_hz: float, pass_db: float, stop_hz: float, stop_db: float, *, prefix: str = ""
) -> int:
    """Return the least order of an analogue Butterworth filter, low-pass or high-pass.

    ``prefix`` stands before the names of the parameters in what is raised. ParameterError where
    the edges are so close that the filter would not compute well.
    """
    edges = (pass_hz, pass_db, stop_hz, stop_db)
    return _computable(butterworth.least_order(*edges), *edges, prefix=prefix)


def _computable(
    order: int, pass_hz: float, pass_db: float, stop_hz: float, stop_db: float, *, prefix: str
) -> int:
    if order > HIGHEST_ORDER:
        raise ParameterError(
            f"{prefix}stop_hz = {stop_hz}: a Butterworth filter between {pass_db} dB at "
            f"{pass_hz} Hz and {stop_db} dB there is of order {order}, more than "
            f"{HIGHEST_ORDER}; move the edges apart"
        )
    return order


def half_power_hz(params: FilterParams, *, tick_s: float) -> Value:
    """Return the -3 dB frequency [Hz] of a filter that has one.

    Of the first order that of the analogue filter, of a Butterworth filter that of the sampled
    one; infinite for ``none`` and ``integrate_and_dump``, which have no such parameter.
    """
    return DESIGNS[params.kind].half_power_hz(params, tick_s)


def design(params: FilterParams, *, tick_s: float) -> Array:
    """Return the filter as second-order sections ``b0 b1 b2 1 a1 a2``.

    First order: exact under a held input, y+ = p y + (1-p) u with p = exp(-a T_c).

    Butterworth: the least order that has both attenuations (:func:`order_of`), scaled so that the
    edge named by ``meet`` is met exactly, which leaves something over at the other one.
    ``bilinear`` is pre-warped at that edge, so the sampled filter meets it; ``matched`` maps the
    analogue poles by z = exp(s T_c), without zeros and with unit gain at rest, so it is the
    analogue filter that meets it.

    Returns
    -------
    ndarray
        ``(sections, 6)``; with parameters ``(runs, 1)`` it is ``(sections, 6, runs, 1)``.

    Raises
    ------
    ParameterError
        If ``bilinear`` is to meet an edge that is not below half the tick rate.
    """
    return DESIGNS[params.kind].sections(params, tick_s)


def stacked(designs: Sequence[Array]) -> Array:
    """Return the sections of runs as one array ``(sections, 6, runs, 1)``; the shorter filters are
    filled up with sections that change nothing.
    """
    sections = max(map(len, designs))
    padded = [np.vstack([sos, *[PASS_THROUGH] * (sections - len(sos))]) for sos in designs]
    return np.stack(padded, axis=-1)[..., np.newaxis]


def warped_rad_s(edge_hz: float, tick_s: float) -> float:
    """Return where an analogue filter needs its edge for the bilinear one to have it there."""
    return 2.0 / tick_s * math.tan(math.pi * edge_hz * tick_s)


def runs_of(params: P) -> list[P]:
    """Return plain parameters for each run of a batch; the parameters themselves where no number
    is ``(runs, 1)``.
    """
    stacked = {
        name: np.ravel(value)
        for name in specs(params)
        if isinstance(value := getattr(params, name), np.ndarray)
    }
    runs = max((column.size for column in stacked.values()), default=0)
    columns = {name: np.broadcast_to(column, runs) for name, column in stacked.items()}
    found = []
    for run in range(runs):
        numbers: dict[str, Any] = {name: float(column[run]) for name, column in columns.items()}
        found.append(dataclasses.replace(params, **numbers))  # type: ignore[type-var]
    return found or [params]


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


def _butterworth_half_power_hz(params: FilterParams, tick_s: float) -> float:
    cutoff = _analogue_cutoff_rad_s(params, tick_s)
    if params.warps:
        return math.atan(cutoff * tick_s / 2.0) / (math.pi * tick_s)
    return cutoff / (2.0 * math.pi)


def _butterworth(params: FilterParams, tick_s: float) -> Array:
    cutoff, order = _analogue_cutoff_rad_s(params, tick_s), order_of(params, tick_s=tick_s)
    sections = butterworth.bilinear_sections if params.warps else butterworth.matched_sections
    return sections(order, cutoff, tick_s)


def _of_runs(params: FilterParams, tick_s: float) -> Array:
    runs = runs_of(params)
    designs = [_butterworth(one, tick_s) for one in runs]
    return designs[0] if runs == [params] else stacked(designs)


def _first_order(params: FilterParams, tick_s: float) -> Array:
    p = exponential(-pole_of(params) * tick_s)
    zero = 0.0 * p
    return np.array([[1.0 - p, zero, zero, 1.0 + zero, -p, zero]])


def _first_order_half_power_hz(params: FilterParams, tick_s: float) -> Value:
    return pole_of(params) / (2.0 * math.pi)


class FilterDesign(NamedTuple):
    """The design of one kind of filter: its -3 dB frequency [Hz] and its sections."""

    half_power_hz: Callable[[FilterParams, float], Value] = lambda params, tick_s: math.inf
    sections: Callable[[FilterParams, float], Array] = lambda params, tick_s: np.array(
        [PASS_THROUGH]
    )


DESIGNS: Mapping[str, FilterDesign] = {
    "none": FilterDesign(),
    "first_order": FilterDesign(_first_order_half_power_hz, _first_order),
    "butterworth": FilterDesign(_butterworth_half_power_hz, _of_runs),
    "integrate_and_dump": FilterDesign(),
}
