# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Second-order sections one after the other, for one axis.

Each is in transposed direct form II, at rest at first::

    y = b0 u + s1,   s1+ = b1 u - a1 y + s2,   s2+ = b2 u - a2 y

So before the input of a tick is known its output is already ``rest + gain u``: what a loop without
delay through the filter needs to be solved.
"""

from typing import Any, NamedTuple

from pmwvc_core.law.vectors import chain


class Section(NamedTuple):
    """The coefficients of a section."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


class Delays(NamedTuple):
    """The state of a section."""

    s1: float
    s2: float


# Of one axis: a tuple with the delays of every section. Of a filter: a tuple with its sections.
Cascade = tuple[Delays, ...]
Sections = tuple[Section, ...]


def sections_of(sos: Any) -> Sections:
    """Return the sections of a filter given as ``b0 b1 b2 1 a1 a2``, ``(sections, 6)``."""
    return tuple(Section(*(float(row[k]) for k in (0, 1, 2, 4, 5))) for row in sos)


def resting_cascade(p: Sections) -> Cascade:
    """Return a filter at rest, of one axis."""
    return tuple(Delays(0.0, 0.0) for _ in p)


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
        y = p[i].b0 * y + s[i].s1
    return y


def cascade(s: Cascade, u: float, p: Sections) -> tuple[Cascade, float]:
    """Take the input of a tick; return the output."""
    return chain(_section, s, u, p)


def _section(s: Delays, u: float, p: Section) -> tuple[Delays, float]:
    y = p.b0 * u + s.s1
    return Delays(p.b1 * u - p.a1 * y + s.s2, p.b2 * u - p.a2 * y), y
