# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of answers of the model: transmitted admittance, and a stability map: regions and
boundary.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.charts import style
from pmwvc_analysis.charts.chart import Chart, Curve, Level, Panel
from pmwvc_analysis.figures.recorded import conditions, title
from pmwvc_analysis.maps.maps import Grid, growth_per_s
from pmwvc_analysis.transparency.transparency import Transparency
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.names import spec_of
from pmwvc_core.scenario.scenario import Scenario

BELOW = 0.3  # lower end of the vertical axis, of the smallest value of the link
DOTTED, DASH_DOT = (2.0, 3.0), (12.0, 3.0, 2.0, 3.0)
SMOOTH = 12  # rows and columns from which a boundary is drawn as a line
SPREAD_PER_S = 10.0  # growth rates over which colour goes, either way
OVER_FREQUENCY = partial(Panel, x_label="frequency [Hz]", x_log=True)


def transparency(found: Transparency, scenario: Scenario, *, live: bool) -> Chart:
    """Return magnitude and phase of x/f of link and ideal."""
    hertz = found.frequency_hz
    curves = (
        ("link, exact model", found.admittance, "u0", ()),
        ("ideal: direct, no delay", found.ideal_admittance, "object", DOTTED),
    )
    size = [Curve(label, hertz, np.abs(x), tint, dash) for label, x, tint, dash in curves]
    degrees = [np.degrees(np.unwrap(np.angle(x))) for _, x, _, _ in curves]
    pairs = zip(curves, degrees, strict=True)
    phase = [Curve(label, hertz, y, tint, dash) for (label, _, tint, dash), y in pairs]
    highest = float(np.nanmax(np.concatenate([each.y for each in size])))
    y_range = (BELOW * float(size[0].y.min()), 1.4 * highest)
    rendered = found.rendered
    levels = []
    if rendered.admittance_dc is not None and rendered.k_felt is not None:
        levels = [Level(f"1 / {rendered.k_felt:.4g} N/m", rendered.admittance_dc, "u0")]
    if rendered.first_peak_hz is not None:
        across: Array = np.full(2, rendered.first_peak_hz)
        label = f"first peak {rendered.first_peak_hz:.3g} Hz"
        size.append(Curve(label, across, np.array(y_range), "target", DASH_DOT, 1.0))
    along = f" along axis {found.axis + 1}" if scenario.dof > 1 else ""
    sizes = OVER_FREQUENCY("|x / f| [m/N]", size, levels=levels, y_range=y_range)
    source = "phases of a live session" if live else "phases of the simulator"
    return Chart(
        "transparency",
        "Transmitted admittance",
        "Position of the device per force of the hand.",
        [
            replace(sizes, y_log=True, height=240.0),
            OVER_FREQUENCY("phase [°]", phase, height=200.0),
        ],
        title(f"Transmitted admittance of {found.user}{along}", scenario),
        conditions(scenario, source, without={"seed"}),
    )


def stability_map(folder: Path, grid: Grid, radius: Array) -> list[Path]:
    """Write a map as PNG and SVG; return the files."""
    import matplotlib

    with matplotlib.rc_context({**style.SETTINGS, "axes.grid": False}):
        return style.save(_figure(grid, radius), folder, "map")


def _figure(grid: Grid, radius: Array) -> Any:
    model = "exact model" + (", phases of a live session" if grid.live else "")
    varied = {"seed", *(axis.name.rpartition(".")[2] for axis in (grid.x, grid.y))}
    figure, (axes,) = style.canvas(
        [345.0],
        title=title("Stability", grid.scenario),
        note=conditions(grid.scenario, model, without=varied),
    )
    x, y = np.array(grid.x.values), np.array(grid.y.values)
    spread: Any = {"vmin": -SPREAD_PER_S, "vmax": SPREAD_PER_S}
    cells = x, y, growth_per_s(grid, radius)
    mesh = axes.pcolormesh(*cells, shading="nearest", cmap=_colours(), rasterized=True, **spread)
    figure.colorbar(mesh, ax=axes, extend="both", label="growth rate [1/s] (stable: up to 0)")
    # Between few rows (delays in whole frames) a line would show what is not there.
    if min(radius.shape) >= SMOOTH and radius.min() <= 1.0 < radius.max():
        axes.contour(x, y, radius, levels=[1.0], colors="black", linewidths=1.6)
        axes.plot([], [], color="black", lw=1.6, label="boundary")
        axes.legend(loc="upper left", bbox_to_anchor=(0.0, 1.1), borderaxespad=0.0)
    axes.set_xlabel(label_of(grid.x.name))
    axes.set_ylabel(label_of(grid.y.name))
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
