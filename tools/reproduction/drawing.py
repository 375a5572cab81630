# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sheets with several panels, alike for all figures of the reproduction."""

from typing import Any

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_core.numeric import Array
from reproduction.figure import Values

REGION = "#BBD7EC"
EDGE = "#0B4F79"
LINES = ("-", "--", "-.", ":")
OBJECT = style.LIGHT["object"]


def colour_of(index: int) -> str:
    """Return a user's colour."""
    return style.LIGHT[style.user_tint(index)]


def sheet(
    result: Values, rows: int, columns: int, *, size_in: tuple[float, float]
) -> tuple[Any, Any]:
    """Return a figure and its axes ``(rows, columns)``: the title of the result above, with the
    number of the dissertation's figure where it is one, and its remark below.
    """
    import textwrap

    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size_in, dpi=style.DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, columns, squeeze=False)
    name = result["figure"]
    number = f"App. {name[0]}, Fig. {name[1:]} · " if name[0].isupper() else ""
    remark = "\n".join(textwrap.wrap(result["remark"], int(size_in[0] * 16)))
    title = "\n".join(textwrap.wrap(f"{number}{result['title']}", int(size_in[0] * 9.5)))
    figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold")
    figure.supxlabel(remark, x=0.01, ha="left", fontsize=8, color="#555555")
    return figure, axes


def numbers(values: Any) -> Array:
    """Return values of a result as an array; what is not finite there is NaN."""
    return np.array(values, dtype=float)


def region(axes: Any, panel: Any) -> None:
    """Colour where a map of spectral radii is stable, over both stiffnesses."""
    k = numbers(panel["k_n_per_m"])
    excess = numbers(panel["radius"]) - 1.0 - 1e-9
    if np.any(excess <= 0.0):
        axes.contourf(k, k, excess, levels=[-2.0, 0.0], colors=[REGION])
        axes.contour(k, k, excess, levels=[0.0], colors=[EDGE], linewidths=1.2)
    limit = panel["k_max"]
    if limit:
        axes.plot([limit], [limit], "o", color=style.LIGHT_USERS[1], markersize=5, zorder=4)
        axes.annotate(
            f"{limit:.0f} N/m", (limit, limit), xytext=(5, 5), textcoords="offset points"
        )
    else:
        axes.text(0.5, 0.5, "nothing is stable", ha="center", transform=axes.transAxes)
    axes.set_xlim(0.0, k[-1])
    axes.set_ylim(0.0, k[-1])
    axes.set_aspect("equal")
