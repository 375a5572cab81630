# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc map``: a stability map over two parameters."""

import argparse
import contextlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import doing, terminal
from pmwvc_core.errors import PmwvcError, RecordingError

if TYPE_CHECKING:
    from pmwvc_analysis.maps.maps import Grid, MapAxis, MapPoint, Points
    from pmwvc_core.scenario.scenario import Scenario


MOST_POINTS = 1_000_000
AXIS: Any = {"required": True, "metavar": "NAME=A:B:N"}
NOT_IN_MODEL = ("name", "description", "duration_s", "seed", "operator", "safety", "task", "side")


@cli.command(
    *cli.MODEL,
    cli.argument("--x", "parameter along x", **AXIS),
    cli.argument("--y", "parameter along y", **AXIS),
    cli.FOLDER.but("session folders to draw as points", name="--sessions", nargs="+", default=[]),
    cli.OUT.but("where to write (default: maps/<scenario>-<y>-<x>-<key of all parameters>)"),
    cli.argument("--workers", "processes (default: all cores)", type=int, metavar="N"),
    cli.argument("--dask", "compute on a Dask cluster", metavar="ADDRESS"),
    cli.JSON.but("print map.json on stdout only"),
)
def map_(arguments: argparse.Namespace) -> cli.Result:
    """Draw a stability map over two parameters, with measured sessions as points.

    examples:
      pmwvc map thesis_controlled_16ms --set server.coupling=one_frame_late \\
          --x server.contact_stiffness=0:3000:100 --y link.delay_s=0:0.024:4
      pmwvc map carry_16ms --x server.contact_stiffness=0:3000:60 --y link.delay_s=0:0.048:7 \\
          --sessions sessions/*carry*
      pmwvc map wall --x server.contact_damping=0:40:100 --y server.contact_stiffness=0:5000:100

    NAME=FIRST:LAST:COUNT. The map is written as map.png, .svg, .npz, .csv, .mat and .json.
    """
    scenario = cli.scenario_of(arguments)
    from pmwvc_analysis.figures.model_charts import stability_map
    from pmwvc_analysis.maps.maps import Grid, boundary_words, compute, write_data
    from pmwvc_analysis.models.linearize import stable

    workers, dask, console = arguments.workers, arguments.dask, terminal()
    if workers is not None and workers < 1:
        raise PmwvcError(f"--workers {workers}: must be >= 1")
    x, y = axis_of(scenario, arguments.x, "--x: "), axis_of(scenario, arguments.y, "--y: ")
    if x.name == y.name or len(x.values) * len(y.values) > MOST_POINTS:
        raise PmwvcError(f"--x and --y: two different parameters and at most {MOST_POINTS} points")
    grid = Grid(scenario, x, y, live=arguments.live)
    measured = [measured_in(session, grid) for session in arguments.sessions]
    default = f"maps/{scenario.name}-{y.name}-{x.name}-{grid.key[:6]}"
    folder = arguments.out or Path(default)
    finished, size = 0, len(x.values) * len(y.values)
    with doing("computing the map") as work:

        def done(points: "Points") -> None:
            nonlocal finished
            finished += len(points)
            work(min(finished / size, 1.0))

        radius = compute(grid, workers=workers, dask=dask, done=done)
    with doing("drawing the map"):
        paths = write_data(folder, grid, radius, measured)
        paths += stability_map(folder, grid, radius, measured)
    share = f"{size} points, {stable(radius).mean():.1%} of them stable"
    for line in (share, boundary_words(grid, radius), *paths):
        console.print(str(line), markup=False)
    return cli.Result(document=(folder / "map.json").read_text("utf-8"))


def axis_of(scenario: "Scenario", text: str, option: str = "") -> "MapAxis":
    """Return the axis of ``NAME=A:B:N``; else PmwvcError with the option."""
    from pmwvc_analysis.maps.maps import MapAxis
    from pmwvc_core.scenario.names import value_of, varied

    name, _, span = text.partition("=")
    try:
        value_of(scenario, name)  # refuses what is none
        first, last, count = span.split(":")
        values = _spread(float(first), float(last), int(count))
        for edge in (values[0], values[-1]):
            varied(scenario, name, edge)  # refuses what is out of range
    except PmwvcError as error:
        raise PmwvcError(f"{option}{error}") from None
    except ValueError:
        form = "must be NAME=FIRST:LAST:COUNT, e.g. server.contact_stiffness=0:3000:100"
        raise PmwvcError(f"{option}{text}: {form}") from None
    return MapAxis(name, values)


def _spread(first: float, last: float, count: int) -> tuple[float, ...]:
    import numpy as np

    if count < 1 or (count > 1 and last <= first):
        raise ValueError("empty range")
    # Rounded, so that 0.016 is written for the delay of 16 ms.
    return tuple(float(f"{value:.12g}") for value in np.linspace(first, last, count))


def measured_in(folder: Path, grid: "Grid") -> "MapPoint":
    """Return a session as a point of a map; RecordingError where it has no scenario or verdict."""
    from pmwvc_analysis.maps.maps import MapPoint
    from pmwvc_analysis.recording.reader import read_scenario
    from pmwvc_core.scenario.names import value_of

    scenario, stable = read_scenario(folder), None
    with contextlib.suppress(OSError, ValueError, KeyError):
        stable = json.loads((folder / "summary.json").read_text("utf-8"))["stable"]
    if scenario is None or stable is None:
        needed = "no session with scenario.yaml and summary.json (pmwvc report writes it)"
        raise RecordingError(f"{folder}: {needed}")
    if wrong := differences(scenario, grid):
        raise RecordingError(f"{folder}: not a point of this map: {'; '.join(wrong)}")
    x, y = value_of(scenario, grid.x.name), value_of(scenario, grid.y.name)
    assert x is not None and y is not None  # a grid has no other parameters
    return MapPoint(folder.name, x, y, bool(stable))


def differences(scenario: "Scenario", grid: "Grid") -> list[str]:
    """Return which parameters of the model a session has other than a map, axes aside."""
    from pmwvc_core.scenario.names import value_of, varied

    wanted = grid.scenario
    if len(scenario.users) != len(wanted.users):
        return [f"users = {len(scenario.users)}, the map has {len(wanted.users)}"]
    for axis in (grid.x, grid.y):
        wanted = varied(wanted, axis.name, value_of(scenario, axis.name))
    theirs, ours = scenario.flat(), wanted.flat()
    return [
        f"{name} = {theirs.get(name)}, the map has {ours.get(name)}"
        for name in sorted(theirs.keys() | ours.keys())
        if theirs.get(name) != ours.get(name)
        and not any(part in NOT_IN_MODEL for part in name.split("."))
    ]
