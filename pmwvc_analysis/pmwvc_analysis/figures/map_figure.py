# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The figure of a stability map: regions, boundary, and sessions as points."""

from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_analysis.figures.recorded import conditions, title
from pmwvc_analysis.maps.maps import Grid, MapPoint, growth_per_s
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.names import spec_of

SMOOTH = 12  # rows and columns from which a boundary is drawn as a line
SPREAD_PER_S = 10.0  # growth rates over which colour goes, either way


def draw(folder: Path, grid: Grid, radius: Array, measured: list[MapPoint]) -> list[Path]:
    """Write a map as PNG and SVG; return the files."""
    import matplotlib

    with matplotlib.rc_context({**style.SETTINGS, "axes.grid": False}):
        return style.save(_figure(grid, radius, measured), folder, "map")


def _figure(grid: Grid, radius: Array, measured: list[MapPoint]) -> Any:
    model = "exact model" + (", phases of a live session" if grid.live else "")
    varied = {"seed", *(axis.name.rpartition(".")[2] for axis in (grid.x, grid.y))}
    figure, (axes,) = style.canvas(
        [345.0],
        title=title("Stability", grid.scenario),
        note=conditions(grid.scenario, model, without=varied),
    )
    x, y = np.array(grid.x.values), np.array(grid.y.values)
    spread: Any = {"vmin": -SPREAD_PER_S, "vmax": SPREAD_PER_S}
    cells = _edges(x), _edges(y), growth_per_s(grid, radius)
    mesh = axes.pcolormesh(*cells, cmap=_colours(), rasterized=True, **spread)
    figure.colorbar(mesh, ax=axes, extend="both", label="growth rate [1/s] (stable: up to 0)")
    # Between few rows (delays in whole frames) a line would show what is not there.
    if min(radius.shape) >= SMOOTH and radius.min() <= 1.0 < radius.max():
        axes.contour(x, y, radius, levels=[1.0], colors="black", linewidths=1.6)
        axes.plot([], [], color="black", lw=1.6, label="boundary")
    for flag, marker, face, label in (
        (True, "o", "white", "session, stable"),
        (False, "X", style.LIGHT["alarm"], "session, not stable"),
    ):
        at = [(point.x, point.y) for point in measured if point.stable is flag]
        if at:
            look: Any = {"facecolor": face, "edgecolor": "black", "zorder": 3, "clip_on": False}
            across, up = np.array(at).T
            axes.scatter(across, up, s=70, marker=marker, label=label, **look)
    axes.set_xlabel(label_of(grid.x.name))
    axes.set_ylabel(label_of(grid.y.name))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", bbox_to_anchor=(0.0, 1.1), ncols=3, borderaxespad=0.0)
    return figure


def _colours() -> Any:
    """Return blue for stable and orange to red for unstable, darker away from the edge at zero."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    below = colormaps["Blues_r"](np.linspace(0.25, 0.95, 128))
    above = colormaps["YlOrRd"](np.linspace(0.35, 1.0, 128))
    return ListedColormap(np.vstack([below, above]))


def label_of(name: str) -> str:
    """Return a parameter's name with its unit."""
    unit = spec_of(name).unit
    return f"{name} [{unit}]" if unit and unit != "-" else name


def _edges(values: Array) -> Array:
    """Return the borders of cells around grid points."""
    if len(values) == 1:
        half = 0.05 * abs(values[0]) or 0.5
        return np.array([values[0] - half, values[0] + half])
    middles = 0.5 * (values[1:] + values[:-1])
    first, last = 2.0 * values[0] - middles[0], 2.0 * values[-1] - middles[-1]
    return np.concatenate([[first], middles, [last]])
