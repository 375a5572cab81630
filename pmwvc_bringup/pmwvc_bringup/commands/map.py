# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc map``: a stability map over two parameters."""

import argparse
from typing import TYPE_CHECKING, Any

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import doing, terminal
from pmwvc_core.errors import PmwvcError

if TYPE_CHECKING:
    from pmwvc_analysis.maps.maps import MapAxis
    from pmwvc_core.scenario.scenario import Scenario


MOST_POINTS = 1_000_000
AXIS: Any = {"required": True, "metavar": "NAME=A:B:N"}


@cli.command(
    *cli.MODEL,
    cli.argument("--x", "parameter along x", **AXIS),
    cli.argument("--y", "parameter along y", **AXIS),
    cli.OUT.but("new or empty folder (default: sessions/<UTC time>-<scenario>-map)"),
    cli.argument("--dask", "compute on a Dask cluster", metavar="ADDRESS"),
    cli.JSON.but("print map.json on stdout only"),
)
def map_(arguments: argparse.Namespace) -> cli.Result:
    """Draw a stability map over two parameters.

    examples:
      pmwvc map thesis_controlled_16ms --set server.coupling=one_frame_late \\
          --x server.contact_stiffness=0:3000:100 --y link.delay_s=0:0.024:4
      pmwvc map carry_16ms --x server.contact_stiffness=0:3000:60 --y link.delay_s=0:0.048:7
      pmwvc map wall --x server.contact_damping=0:40:100 --y server.contact_stiffness=0:5000:100

    NAME=FIRST:LAST:COUNT. The map is written as map.png, .svg and .json.
    """
    scenario = cli.scenario_of(arguments)
    from pmwvc_analysis.figures.model_charts import stability_map
    from pmwvc_analysis.maps.maps import Grid, compute, write_data
    from pmwvc_analysis.models.linearize import stable
    from pmwvc_bringup.session.surroundings import new_folder

    console = terminal()
    x, y = axis_of(scenario, arguments.x, "--x: "), axis_of(scenario, arguments.y, "--y: ")
    if x.name == y.name or len(x.values) * len(y.values) > MOST_POINTS:
        raise PmwvcError(f"--x and --y: two different parameters and at most {MOST_POINTS} points")
    grid = Grid(scenario, x, y, live=arguments.live)
    folder = new_folder(f"{scenario.name}-map", arguments.out)
    with doing("computing the map") as work:
        radius = compute(grid, dask=arguments.dask, progress=work)
    with doing("drawing the map"):
        paths = [write_data(folder, grid, radius), *stability_map(folder, grid, radius)]
    share = f"{radius.size} points, {stable(radius).mean():.1%} of them stable"
    for line in (share, *paths):
        console.print(str(line), markup=False)
    return cli.Result(document=(folder / "map.json").read_text("utf-8"))


def axis_of(scenario: "Scenario", text: str, option: str = "") -> "MapAxis":
    """Return the axis of ``NAME=A:B:N``; else PmwvcError with the option."""
    import numpy as np

    from pmwvc_analysis.maps.maps import MapAxis
    from pmwvc_core.scenario.names import varied

    name, _, span = text.partition("=")
    try:
        first, last, count = span.split(":")
        if int(count) < 2 or float(last) <= float(first):
            raise ValueError("no range")
        spread = np.linspace(float(first), float(last), int(count)).tolist()
        values = tuple(float(f"{value:.12g}") for value in spread)  # 0.016 for a delay of 16 ms
        for edge in (values[0], values[-1]):
            varied(scenario, name, edge)  # refuses what is none, or out of range
    except PmwvcError as error:
        raise PmwvcError(f"{option}{error}") from None
    except ValueError:
        form = "must be NAME=FIRST:LAST:COUNT, e.g. server.contact_stiffness=0:3000:100"
        raise PmwvcError(f"{option}{text}: {form}") from None
    return MapAxis(name, values)
