# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The anti-aliasing filter of the outgoing wave, with the drop from tick rate to packet rate
(App. A, B).

A packet carries the output at a frame start::

    none                the wave of the last tick
    first_order         y+ = p y + (1 - p) u: the output after a tick already holds that tick
    butterworth         second-order sections (:mod:`.cascade`)
    integrate_and_dump  the mean over the frame, the integral of M ticks divided by their duration

(mean)^2 M <= sum of squares, so the mean never sends more energy than came in. A frame that lost
ticks is still divided by M, a longer one by its own number.

Equations: docs/theory.md 2.1, 2.5.
"""

import math
from typing import Any, NamedTuple

from pmwvc_core.law.family import Family
from pmwvc_core.law.vectors import Vector, columns, each, plus, scaled, zero
from pmwvc_core.law.wave.cascade import Cascade, Sections, cascade, resting_cascade, sections_of
from pmwvc_core.params import FilterParams
from pmwvc_core.wave.design.filter_design import design, pole_of


class Passing(NamedTuple):
    """No filter: the wave of the last tick."""

    y: Vector


class FirstOrder(NamedTuple):
    """The output."""

    y: Vector


class Mean(NamedTuple):
    """The sum of a frame so far, and of how many ticks."""

    total: Vector
    ticks: int


class Butterworth(NamedTuple):
    """The output, and the delays of every axis."""

    y: Vector
    delays: tuple[Cascade, ...]


filter_step = Family("filter_step")  # (s, u, p) -> (s, y): the wave of a tick [sqrt(W)]
filter_sample = Family("filter_sample")  # (s, p) -> (s, y): what a packet carries


def filter_params(params: FilterParams, *, tick_s: float, rate_drop: int) -> Any:
    """Return the parameters of a filter: its sections, its pole, or M, the ticks of a frame."""
    if params.kind == "butterworth":
        return sections_of(design(params, tick_s=tick_s))
    if params.kind == "first_order":
        return math.exp(-float(pole_of(params)) * tick_s)
    return rate_drop


def resting_filter(params: FilterParams, axes: int, p: Any) -> Any:
    """Return a filter at rest."""
    nothing = (0.0,) * axes
    if params.kind == "butterworth":
        return Butterworth(nothing, (resting_cascade(p),) * axes)
    if params.kind == "first_order":
        return FirstOrder(nothing)
    return Passing(nothing) if params.kind == "none" else Mean(nothing, 0)


@filter_step.member(Passing)
def _pass(s: Passing, u: Vector, p: int) -> tuple[Passing, Vector]:
    return Passing(u), u


@filter_sample.member(Passing, FirstOrder, Butterworth)
def _latest(s: Any, p: Any) -> tuple[Any, Vector]:
    return s, s.y


@filter_step.member(FirstOrder)
def _first_order(s: FirstOrder, u: Vector, pole: float) -> tuple[FirstOrder, Vector]:
    y = plus(scaled(u, 1.0 - pole), scaled(s.y, pole))
    return FirstOrder(y), y


@filter_step.member(Mean)
def _mean(s: Mean, u: Vector, rate_drop: int) -> tuple[Mean, Vector]:
    s = Mean(plus(s.total, u), s.ticks + 1)
    return s, _mean_of(s, rate_drop)


@filter_sample.member(Mean)
def _dump(s: Mean, rate_drop: int) -> tuple[Mean, Vector]:
    return Mean(zero(s.total), 0), _mean_of(s, rate_drop)


def _mean_of(s: Mean, rate_drop: int) -> Vector:
    return each(_divided, (s.total,), max(s.ticks, rate_drop))


def _divided(total: float, ticks: int) -> float:
    return total / ticks


@filter_step.member(Butterworth)
def _butterworth(s: Butterworth, u: Vector, p: Sections) -> tuple[Butterworth, Vector]:
    delays, y = columns(each(cascade, (s.delays, u), p))
    return Butterworth(y, delays), y
