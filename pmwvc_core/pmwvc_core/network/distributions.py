# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Distributions of jitter by name: quantile function, mean and standard deviation [s].

A packet's jitter is the quantile of its random number, so that the marginal distribution is exact
whatever correlation the numbers have.
"""

import bisect
import functools
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from pmwvc_core.errors import ParameterError, refusal
from pmwvc_core.network.delay_trace import recording_of
from pmwvc_core.params import LinkParams

STANDARD_NORMAL = NormalDist()
LEAST = 1e-17  # in place of 0, whose normal quantile is infinite
TAIL = 3.0  # usual tail index of Pareto, as in the tables of Linux
USUAL_SHAPES = {"gamma": 2.0, "lognormal": 0.5, "pareto": TAIL, "paretonormal": TAIL}
FORM = "must be probability:seconds from 0 to 1, rising, separated by blanks"


@dataclass(frozen=True)
class Quantiles:
    """Probabilities from 0 to 1, and the value at each [s]."""

    probability: tuple[float, ...]
    value_s: tuple[float, ...]

    def at(self, u: float) -> float:
        """Return the quantile [s] of a number in [0, 1]."""
        p, x = self.probability, self.value_s
        k = min(bisect.bisect_right(p, u), len(p) - 1) - 1
        return x[k] + (x[k + 1] - x[k]) * (u - p[k]) / (p[k + 1] - p[k])

    @functools.cached_property
    def moments(self) -> tuple[float, float]:
        """Return mean and standard deviation [s]."""
        mean = square = 0.0
        points = itertools.pairwise(zip(self.probability, self.value_s, strict=True))
        for (p, x), (q, y) in points:
            mean += (q - p) * (x + y) / 2.0
            square += (q - p) * (x * x + x * y + y * y) / 3.0
        return mean, math.sqrt(max(square - mean * mean, 0.0))


@functools.lru_cache(maxsize=64)
def quantiles_of(text: str) -> Quantiles:
    """Read ``link.jitter_quantiles``; ParameterError with the text and the form it must have."""
    refused = ParameterError(f"jitter_quantiles = {text!r}: {FORM}")
    try:
        pairs = [tuple(map(float, word.split(":"))) for word in text.split()]
        probability, value_s = (tuple(column) for column in zip(*pairs, strict=True))
    except ValueError:
        raise refused from None
    rising = all(a < b for a, b in itertools.pairwise(probability))
    right = rising and probability[0] == 0.0 and probability[-1] == 1.0
    growing = all(a <= b for a, b in itertools.pairwise(value_s))
    if not right or not growing or not 0.0 <= value_s[0] <= value_s[-1] <= 60.0:
        raise refused
    return Quantiles(probability, value_s)


@dataclass(frozen=True)
class Distribution:
    """One distribution of jitter."""

    words: str  # what it is, for sentences
    at: Callable[[LinkParams, float], float]  # quantile of a number in [0, 1) [s]
    moments: Callable[[LinkParams], tuple[float, float]]  # mean and standard deviation [s]
    # what is wrong between settings that are each right; empty where nothing is
    conflict: Callable[[LinkParams], str] = lambda params: ""
    # raises where what it is made from, a text or a file, cannot be used
    check: Callable[[LinkParams], object] = lambda params: None
    sized: bool = True  # whether jitter_s is its size; without it there is no jitter
    half_width: bool = False  # whether jitter_s is a half-width: no table in Linux
    linux: bool = False  # whether a table of it comes with tc


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


def _gamma(params: LinkParams, u: float) -> float:
    from scipy.special import gammaincinv  # takes long to import, and only this needs it

    shape = shape_of(params)
    return params.jitter_s / shape * float(gammaincinv(shape, u))


def _lognormal_moments(params: LinkParams) -> tuple[float, float]:
    square = shape_of(params) ** 2
    mean = params.jitter_s * math.exp(0.5 * square)
    return mean, mean * math.sqrt(math.expm1(square))


def _centred(params: LinkParams) -> tuple[float, float]:
    return 0.0, params.jitter_s


def _samples(params: LinkParams) -> tuple[float, ...]:
    return recording_of(params).delays_s


def _table_moments(params: LinkParams) -> tuple[float, float]:
    samples = np.array(_samples(params))
    return float(samples.mean()), float(samples.std())


def _tail_conflict(params: LinkParams) -> str:
    if 0.0 < params.jitter_shape <= 2.0:
        return (
            f"jitter_shape = {params.jitter_shape:g}: must be > 2 for {params.jitter} (0: 3); "
            "otherwise it has no standard deviation"
        )
    return ""


def file_conflict(params: LinkParams) -> str:
    """Return that a file is missing; empty where one is named."""
    if params.trace_file:
        return ""
    return f"trace_file is missing: jitter = {params.jitter} needs a file"


DISTRIBUTIONS = {
    "uniform": Distribution(
        "evenly spread",
        lambda p, u: p.jitter_s * (2.0 * u - 1.0),
        lambda p: (0.0, p.jitter_s / math.sqrt(3.0)),
        half_width=True,
    ),
    "normal": Distribution(
        "normally distributed", lambda p, u: p.jitter_s * normal(u), _centred, linux=True
    ),
    "pareto": Distribution(
        "Pareto distributed",
        lambda p, u: p.jitter_s * pareto(u, shape_of(p)),
        _centred,
        conflict=_tail_conflict,
        linux=True,
    ),
    "paretonormal": Distribution(
        "a quarter normal and three quarters Pareto",
        lambda p, u: p.jitter_s * pareto_normal(u, shape_of(p)),
        _centred,
        conflict=_tail_conflict,
        linux=True,
    ),
    "gamma": Distribution(
        "longer by a gamma distribution",
        _gamma,
        lambda p: (p.jitter_s, p.jitter_s / math.sqrt(shape_of(p))),
    ),
    "lognormal": Distribution(
        "longer by a log-normal distribution",
        lambda p, u: p.jitter_s * math.exp(shape_of(p) * normal(u)),
        _lognormal_moments,
    ),
    "quantiles": Distribution(
        "longer by a distribution given by quantiles",
        lambda p, u: quantiles_of(p.jitter_quantiles).at(u),
        lambda p: quantiles_of(p.jitter_quantiles).moments,
        conflict=lambda p: refusal(quantiles_of, p.jitter_quantiles),
        sized=False,
    ),
    "table": Distribution(
        "longer by delays drawn from a file",
        lambda p, u: _samples(p)[int(u * len(_samples(p)))],
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
