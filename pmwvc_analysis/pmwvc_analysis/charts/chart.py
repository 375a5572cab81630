# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A figure as data: what is drawn, not how. Renderers: ``chart.js`` (report) and
``chart_files`` (``plots/*.png`` and ``.svg``).

Curves that coincide stay visible: in a panel, a curve is dashed or narrower than every curve
drawn before it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from pmwvc_core.numeric import Array

Dash = tuple[float, ...]  # on, off, ... [px]; empty: solid
DASHES: tuple[Dash, ...] = (
    (), (9, 5), (2, 3), (12, 3, 2, 3), (5, 2.5), (1.5, 1.5), (14, 4), (8, 3, 2, 3, 2, 3),
)  # fmt: skip
Span = tuple[float, float]


@dataclass(frozen=True)
class Curve:
    """A curve. Where ``x`` steps by more than 1.5 ``period``, it is interrupted (0: never)."""

    label: str
    x: Array
    y: Array
    tint: str
    dash: Dash = ()
    width: float = 1.6
    period: float = 0.0


@dataclass(frozen=True)
class Dots:
    """Single points; ``mark`` is ``dot``, ``ring``, ``cross`` or ``plus``."""

    label: str
    x: Array
    y: Array
    tint: str
    mark: str = "dot"


@dataclass(frozen=True)
class Band:
    """A marked stretch of time."""

    label: str
    span: Span
    tint: str = "alarm"


@dataclass(frozen=True)
class Level:
    """A horizontal line."""

    label: str
    y: float
    tint: str = "alarm"


@dataclass(frozen=True)
class Panel:
    """One pair of axes. Logarithmic axes show positive values only."""

    y_label: str
    lines: Sequence[Curve] = ()
    dots: Sequence[Dots] = ()
    bands: Sequence[Band] = ()
    levels: Sequence[Level] = ()
    title: str = ""
    tint: str = "ink"
    x_label: str = "time [s]"
    x_log: bool = False
    y_log: bool = False
    with_zero: bool = False
    height: float = 180.0
    y_range: Span | None = None  # of the curves where it is None
    x_names: Sequence[str] = ()  # labels at 0, 1, 2... instead of numbers

    @property
    def of_time(self) -> bool:
        """Tell whether the horizontal axis is the session's time, common to all panels."""
        return self.x_label == "time [s]"


@dataclass(frozen=True)
class Chart:
    """Panels above one another with a heading and a caption."""

    name: str
    heading: str
    caption: str
    panels: Sequence[Panel]
    title: str = ""
    note: str = ""
    events: Sequence[tuple[float, str]] = ()  # time [s], number in the list

    def labelled(self, index: int) -> bool:
        """Tell whether a panel has a labelled axis: the last one above another horizontal axis."""
        below = self.panels[index + 1 :]
        return not below or below[0].x_label != self.panels[index].x_label
