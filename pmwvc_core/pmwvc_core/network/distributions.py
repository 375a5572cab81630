# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Distributions of jitter by name: quantile function, mean and standard deviation [s].

A packet's jitter is the quantile of its random number, so that the marginal distribution is exact
whatever correlation the numbers have.
"""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from pmwvc_core.errors import ParameterError
from pmwvc_core.network.delay_trace import load_delay_trace
from pmwvc_core.network.quantiles import Quantiles, quantiles_of
from pmwvc_core.params import LinkParams

Quantile = Callable[[float], float]  # of a number in [0, 1); seconds
STANDARD_NORMAL = NormalDist()
LEAST = 1e-17  # in place of 0, whose normal quantile is infinite
TAIL = 3.0  # usual tail index of Pareto, as in the tables of Linux
USUAL_SHAPES = {"gamma": 2.0, "lognormal": 0.5, "pareto": TAIL, "paretonormal": TAIL}


@dataclass(frozen=True)
class Distribution:
    """One distribution of jitter.

    Attributes
    ----------
    words
        What it is, for sentences.
    quantile
        Makes the quantile function for the settings of a link.
    moments
        Mean and standard deviation for the settings of a link [s].
    conflict
        What is wrong between settings that are each right; empty where nothing is.
    check
        Raises where what it is made from, a text or a file, cannot be used.
    sized
        Whether ``jitter_s`` is its size; without it there is no jitter.
    half_width
        Whether ``jitter_s`` is a half-width: no table in Linux.
    linux
        Whether a table of it comes with tc.
    """

    words: str
    quantile: Callable[[LinkParams], Quantile]
    moments: Callable[[LinkParams], tuple[float, float]]
    conflict: Callable[[LinkParams], str] = lambda params: ""
    check: Callable[[LinkParams], object] = lambda params: None
    sized: bool = True
    half_width: bool = False
    linux: bool = False


def normal(u: float) -> float:
    """Return the quantile of the standard normal distribution."""
    return STANDARD_NORMAL.inv_cdf(max(u, LEAST))


def shape_of(params: LinkParams) -> float:
    """Return the shape of the distribution, the usual one where none is given."""
    return params.jitter_shape or USUAL_SHAPES.get(params.jitter, 0.0)


def pareto(u: float, tail: float) -> float:
    """Return the quantile of the Pareto distribution with mean 0 and standard deviation 1."""
    mean = tail / (tail - 1.0)
    deviation = math.sqrt(tail / (tail - 2.0)) / (tail - 1.0)
    return float(((1.0 - u) ** (-1.0 / tail) - mean) / deviation)


def pareto_normal(u: float, tail: float) -> float:
    """Return the quantile of a quarter normal and three quarters Pareto, mean 0, deviation 1."""
    return (normal(u) + 3.0 * pareto(u, tail)) / _mixed(tail)


@functools.lru_cache(maxsize=32)
def _mixed(tail: float) -> float:
    """Return the standard deviation of normal + 3 Pareto at the same probability."""
    z = np.linspace(-12.0, 12.0, 4001)
    above = np.array([0.5 * math.erfc(each / math.sqrt(2.0)) for each in z])
    mean = tail / (tail - 1.0)
    deviation = math.sqrt(tail / (tail - 2.0)) / (tail - 1.0)
    density = np.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi)
    together = np.trapezoid(z * (above ** (-1.0 / tail) - mean) / deviation * density, z)
    return math.sqrt(10.0 + 6.0 * float(together))


def _uniform(params: LinkParams) -> Quantile:
    size = params.jitter_s
    return lambda u: size * (2.0 * u - 1.0)


def _normal(params: LinkParams) -> Quantile:
    size = params.jitter_s
    return lambda u: size * normal(u)


def _pareto(params: LinkParams) -> Quantile:
    size, tail = params.jitter_s, shape_of(params)
    return lambda u: size * pareto(u, tail)


def _pareto_normal(params: LinkParams) -> Quantile:
    size, tail = params.jitter_s, shape_of(params)
    return lambda u: size * pareto_normal(u, tail)


def _gamma(params: LinkParams) -> Quantile:
    from scipy.special import gammaincinv  # takes long to import, and only this needs it

    shape = shape_of(params)
    scale = params.jitter_s / shape
    return lambda u: scale * float(gammaincinv(shape, u))


def _lognormal(params: LinkParams) -> Quantile:
    median, sigma = params.jitter_s, shape_of(params)
    return lambda u: median * math.exp(sigma * normal(u))


def _gamma_moments(params: LinkParams) -> tuple[float, float]:
    return params.jitter_s, params.jitter_s / math.sqrt(shape_of(params))


def _lognormal_moments(params: LinkParams) -> tuple[float, float]:
    square = shape_of(params) ** 2
    mean = params.jitter_s * math.exp(0.5 * square)
    return mean, mean * math.sqrt(math.expm1(square))


def _centred(params: LinkParams) -> tuple[float, float]:
    return 0.0, params.jitter_s


def _samples(params: LinkParams) -> tuple[float, ...]:
    trace = load_delay_trace(params.trace_file, params.trace_scale, params.trace_column)
    return trace.delays_s


def _table(params: LinkParams) -> Quantile:
    samples = _samples(params)
    return lambda u: samples[int(u * len(samples))]


def _table_moments(params: LinkParams) -> tuple[float, float]:
    samples = np.array(_samples(params))
    return float(samples.mean()), float(samples.std())


def _quantiles(params: LinkParams) -> Quantiles:
    return quantiles_of(params.jitter_quantiles)


def _tail_conflict(params: LinkParams) -> str:
    if 0.0 < params.jitter_shape <= 2.0:
        return (
            f"jitter_shape = {params.jitter_shape:g}: must be > 2 for {params.jitter} (0: 3); "
            "otherwise it has no standard deviation"
        )
    return ""


def _quantiles_conflict(params: LinkParams) -> str:
    try:
        _quantiles(params)
    except ParameterError as error:
        return str(error)
    return ""


def file_conflict(params: LinkParams) -> str:
    """Return that a file is missing; empty where one is named."""
    if params.trace_file:
        return ""
    return f"trace_file is missing: jitter = {params.jitter} needs a file"


DISTRIBUTIONS = {
    "uniform": Distribution(
        "evenly spread",
        _uniform,
        lambda params: (0.0, params.jitter_s / math.sqrt(3.0)),
        half_width=True,
    ),
    "normal": Distribution("normally distributed", _normal, _centred, linux=True),
    "pareto": Distribution(
        "Pareto distributed", _pareto, _centred, conflict=_tail_conflict, linux=True
    ),
    "paretonormal": Distribution(
        "a quarter normal and three quarters Pareto",
        _pareto_normal,
        _centred,
        conflict=_tail_conflict,
        linux=True,
    ),
    "gamma": Distribution("longer by a gamma distribution", _gamma, _gamma_moments),
    "lognormal": Distribution(
        "longer by a log-normal distribution", _lognormal, _lognormal_moments
    ),
    "quantiles": Distribution(
        "longer by a distribution given by quantiles",
        lambda params: _quantiles(params).at,
        lambda params: _quantiles(params).moments,
        conflict=_quantiles_conflict,
        sized=False,
    ),
    "table": Distribution(
        "longer by delays drawn from a file",
        _table,
        _table_moments,
        conflict=file_conflict,
        check=_samples,
        sized=False,
    ),
}


def drawn(params: LinkParams) -> Distribution | None:
    """Return the distribution of a link's jitter; None where it has none."""
    found = DISTRIBUTIONS.get(params.jitter)
    return found if found and (not found.sized or params.jitter_s > 0.0) else None
