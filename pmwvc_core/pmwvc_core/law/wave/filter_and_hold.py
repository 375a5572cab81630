# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Between tick rate and packet rate: second-order sections, the anti-aliasing filter of the
outgoing wave (App. A, B), and the hold of the returning one (App. B, Eq. 43-54, with corrected
indices).

A section, at rest at first, in transposed direct form II; before the input of a tick is known its
output is already ``rest + gain u``::

    y = b0 u + s1,   s1+ = b1 u - a1 y + s2,   s2+ = b2 u - a2 y

A packet carries the filter's output at a frame start::

    none                the wave of the last tick: a section that changes nothing
    first_order         y+ = p y + (1 - p) u: the output after a tick already holds that tick
    butterworth         as many sections as it needs
    integrate_and_dump  the mean over the frame, M ticks or more; lost ones count

The hold::

    v_m = v_{i-1} + (v_i - v_{i-1}) j/M      delayed first order, for the ticks j = 1..M after a
                                             packet; v_{-1} = 0
    v_m = v_i                                zero order (M = 1 here), and after M ticks

An early packet starts its ramp at the value reached. Equations: docs/theory.md 2.1, 2.5, 3.1, 3.4.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.family import Family
from pmwvc_core.law.vectors import Vector, between, chain, columns, each, plus, scaled, zero


class Section(NamedTuple):
    """The coefficients of a section."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


Delays = tuple[float, float]  # s1, s2: the state of a section
Cascade = tuple[Delays, ...]  # the state of a filter along one axis
Sections = tuple[Section, ...]


def sections_of(sos: Any) -> Sections:
    """Return the sections of a filter given as ``b0 b1 b2 1 a1 a2``, ``(sections, 6)``."""
    return tuple(Section(*(float(row[k]) for k in (0, 1, 2, 4, 5))) for row in sos)


def resting_cascade(p: Sections) -> Cascade:
    """Return a filter at rest, of one axis."""
    return ((0.0, 0.0),) * len(p)


def gain_of(p: Sections) -> float:
    """Return by how much the output follows the input of the same tick."""
    gain = 1.0
    for section in p:
        gain *= section.b0
    return gain


def rest_of(s: Cascade, p: Sections) -> float:
    """Return what the output of the next tick is without input."""
    y = 0.0
    for i in range(len(p)):
        y = p[i].b0 * y + s[i][0]
    return y


def cascade(s: Cascade, u: float, p: Sections) -> tuple[Cascade, float]:
    """Take the input of a tick along one axis; return the output."""
    return chain(_section, s, u, p)


def _section(s: Delays, u: float, p: Section) -> tuple[Delays, float]:
    y = p.b0 * u + s[0]
    return (p.b1 * u - p.a1 * y + s[1], p.b2 * u - p.a2 * y), y


class Mean(NamedTuple):
    """The sum of a frame so far, and of how many ticks."""

    total: Vector
    ticks: int


class Sectioned(NamedTuple):
    """The output of second-order sections, and their delays along every axis."""

    y: Vector
    delays: tuple[Cascade, ...]


filter_step = Family("filter_step")  # (s, u, p) -> (s, y): the wave of a tick [sqrt(W)]
filter_sample = Family("filter_sample")  # (s, p) -> (s, y): what a packet carries


@filter_sample.member(Sectioned)
def _latest(s: Sectioned, p: Sections) -> tuple[Sectioned, Vector]:
    return s, s.y


@filter_step.member(Sectioned)
def _sectioned(s: Sectioned, u: Vector, p: Sections) -> tuple[Sectioned, Vector]:
    delays, y = columns(each(cascade, (s.delays, u), p))
    return Sectioned(y, delays), y


@filter_step.member(Mean)
def _mean(s: Mean, u: Vector, rate_drop: int) -> tuple[Mean, Vector]:
    s = Mean(plus(s.total, u), s.ticks + 1)
    return s, scaled(s.total, 1.0 / max(s.ticks, rate_drop))


@filter_sample.member(Mean)
def _dump(s: Mean, rate_drop: int) -> tuple[Mean, Vector]:
    return Mean(zero(s.total), 0), scaled(s.total, 1.0 / max(s.ticks, rate_drop))


class Hold(NamedTuple):
    """Ramp of the present frame [sqrt(W)], and the ticks of it that are over."""

    start: Vector
    target: Vector
    value: Vector
    done: int


def load(s: Hold, v: Vector) -> Hold:
    """Begin a frame with the packet v [sqrt(W)]."""
    return Hold(s.value, v, s.value, 0)


def hold(s: Hold, ticks: int) -> tuple[Hold, Vector]:
    """Return the wave of the next tick [sqrt(W)]; ``ticks`` is M, or 1 for zero order."""
    done, value = s.done + 1, s.target
    if done < ticks:
        value = between(s.start, s.target, done / ticks)
    return s._replace(value=value, done=done), value
