# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A figure: parameters, a computation that needs nothing else, and a drawing.

The parameters are plain values, so that a committed file tells which of them it was made with. The
result of a computation holds ``data`` (what is drawn) and ``numbers`` (what is claimed).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

Values = dict[str, Any]
DIGITS = 6  # significant digits kept in files


@dataclass(frozen=True)
class Figure:
    """One figure of the dissertation.

    Attributes
    ----------
    name
        Appendix and number: ``B2``.
    title
        What it shows.
    remark
        What the reader must know to compare it with the printed one.
    parameters
        Plain values.
    compute
        From the parameters to ``data`` and ``numbers``.
    draw
        From a result to a matplotlib figure.
    """

    name: str
    title: str
    remark: str
    parameters: Values
    compute: Callable[[Values], Values]
    draw: Callable[[Values], Any]

    def result(self) -> Values:
        """Compute, and say what and with which parameters."""
        return {
            "figure": self.name,
            "title": self.title,
            "remark": self.remark,
            "parameters": self.parameters,
            **plain(self.compute(self.parameters)),
        }


def plain(value: Any) -> Any:
    """Return a value as JSON knows it: lists, and numbers rounded to what is worth keeping."""
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, float | np.floating):
        return float(f"{float(value):.{DIGITS}g}") if np.isfinite(value) else None
    return value
