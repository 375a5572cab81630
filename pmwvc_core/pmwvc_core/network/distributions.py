# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Distributions of jitter by name: quantile function, mean and standard deviation [s].

A packet's jitter is the quantile of its random number, so that the marginal distribution is exact
whatever correlation the numbers have.
"""

import functools
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.errors import ParameterError, refusal
from pmwvc_core.network.delay_trace import recording_of
from pmwvc_core.params import LinkParams

STANDARD_NORMAL = NormalDist()
LEAST = 1e-17  # in place of 0, whose normal quantile is infinite
# Tail index of Pareto as in the tables of Linux.
USUAL_SHAPES = {"gamma": 2.0, "lognormal": 0.5, "pareto": 3.0}
FORM = "must be probability:seconds from 0 to 1, rising, separated by blanks"


class Quantiles(NamedTuple):
    """Probabilities from 0 to 1, and the value at each [s]."""

    probability: tuple[float, ...]
    value_s: tuple[float, ...]

    def at(self, u: float) -> float:
        """Return the quantile [s] of a number in [0, 1]."""
        return float(np.interp(u, self.probability, self.value_s))

    @property
    def moments(self) -> tuple[float, float]:
        """Return mean and standard deviation [s]."""
        weight, x = np.diff(self.probability), np.array(self.value_s)
        low, high = x[:-1], x[1:]
        mean = float(weight @ (low + high)) / 2.0
        square = float(weight @ (low * low + low * high + high * high)) / 3.0
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

    at: Callable[[LinkParams, float], float]  # quantile of a number in [0, 1) [s]
    moments: Callable[[LinkParams], tuple[float, float]]  # mean and standard deviation [s]
    # what is wrong between settings that are each right; empty where nothing is
    conflict: Callable[[LinkParams], str] = lambda params: ""
    # raises where what it is made from, a text or a file, cannot be used
    check: Callable[[LinkParams], object] = lambda params: None
    sized: bool = True  # whether jitter_s is its size; without it there is no jitter
    half_width: bool = False  # whether jitter_s is a half-width


def normal(u: float) -> float:
    """Return the quantile of the standard normal distribution."""
    return STANDARD_NORMAL.inv_cdf(max(u, LEAST))


def _shape(p: LinkParams) -> float:
    """Return the shape of the distribution, the usual one where none is given."""
    return p.jitter_shape or USUAL_SHAPES.get(p.jitter, 0.0)


def _pareto(above: Any, tail: float) -> Any:
    """Return the quantile of the Pareto distribution with mean 0 and standard deviation 1, of the
    probability (one or many) to be above it.
    """
    mean = tail / (tail - 1.0)
    deviation = math.sqrt(tail / (tail - 2.0)) / (tail - 1.0)
    return (above ** (-1.0 / tail) - mean) / deviation


def _gamma(p: LinkParams, u: float) -> float:
    from scipy.special import gammaincinv  # takes long to import, and only this needs it

    return p.jitter_s / _shape(p) * float(gammaincinv(_shape(p), u))


def _lognormal_moments(p: LinkParams) -> tuple[float, float]:
    square = _shape(p) ** 2
    mean = p.jitter_s * math.exp(0.5 * square)
    return mean, mean * math.sqrt(math.expm1(square))


def _tail_conflict(p: LinkParams) -> str:
    wrong = f"jitter_shape = {p.jitter_shape:g}: must be > 2 for {p.jitter} (0: 3)"
    text = f"{wrong}; otherwise it has no standard deviation"
    return text if 0.0 < p.jitter_shape <= 2.0 else ""


def file_conflict(p: LinkParams) -> str:
    """Return that a file is missing; empty where one is named."""
    return "" if p.trace_file else f"trace_file is missing: jitter = {p.jitter} needs a file"


DISTRIBUTIONS = {
    "uniform": Distribution(
        lambda p, u: p.jitter_s * (2.0 * u - 1.0),
        lambda p: (0.0, p.jitter_s / math.sqrt(3.0)),
        half_width=True,
    ),
    "normal": Distribution(lambda p, u: p.jitter_s * normal(u), lambda p: (0.0, p.jitter_s)),
    "pareto": Distribution(
        lambda p, u: p.jitter_s * _pareto(1.0 - u, _shape(p)),
        lambda p: (0.0, p.jitter_s),
        _tail_conflict,
    ),
    "gamma": Distribution(_gamma, lambda p: (p.jitter_s, p.jitter_s / math.sqrt(_shape(p)))),
    "lognormal": Distribution(
        lambda p, u: p.jitter_s * math.exp(_shape(p) * normal(u)), _lognormal_moments
    ),
    "quantiles": Distribution(
        lambda p, u: quantiles_of(p.jitter_quantiles).at(u),
        lambda p: quantiles_of(p.jitter_quantiles).moments,
        conflict=lambda p: refusal(quantiles_of, p.jitter_quantiles),
        sized=False,
    ),
    "table": Distribution(
        lambda p, u: (samples := recording_of(p).delays_s)[int(u * len(samples))],
        lambda p: (float(np.mean(d := recording_of(p).delays_s)), float(np.std(d))),
        conflict=file_conflict,
        check=recording_of,
        sized=False,
    ),
}


def drawn(params: LinkParams) -> Distribution | None:
    """Return the distribution of a link's jitter; None where it has none."""
    found = DISTRIBUTIONS.get(params.jitter)
    return found if found and (not found.sized or params.jitter_s > 0.0) else None
