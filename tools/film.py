#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Write the animated picture of the README from a live session: ``make film``.

Above, the devices in the hands; below, the cube and the avatars on the server; dashed, the
distance between a device and its avatar. A session that does not pass ``--check`` is not drawn.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.patches import Rectangle
from PIL import Image

import pmwvc
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_analysis.charts.style import LIGHT_USERS as COLOURS
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "docs" / "images" / "carry_16ms.gif"
FRAMES_HZ = 12.5
SIZE_IN, DPI = (7.2, 4.4), 100
PALETTE = 48
MM = 1e3
HANDS, SERVER = 1.0, 0.0  # heights of the two sides in the scene
ARROW_MM_PER_N = 10.0


def record(folder: Path, seconds: float) -> None:
    """Run the live session."""
    words = ["run", "carry_16ms", "--duration", str(seconds), "--out", str(folder), "--check"]
    if subprocess.run([ROOT / "pmwvc", *words]).returncode:
        sys.exit("film: the session did not pass its check; run it again on a calmer machine")


def frames(traces: SessionTraces, scenario: Scenario) -> Iterator[Image.Image]:
    """Yield the picture of every instant."""
    figure, axes = plt.subplot_mosaic(
        [["scene", "scene"], ["force", "energy"]],
        figsize=SIZE_IN,
        dpi=DPI,
        height_ratios=[1.15, 1.0],
        layout="constrained",
    )
    canvas = FigureCanvasAgg(figure)
    marks = [_forces(axes["force"], traces), _energies(axes["energy"], traces, scenario)]
    for time_s in np.arange(0.0, traces.duration_s, 1.0 / FRAMES_HZ):
        _scene(axes["scene"], traces, scenario, time_s)
        for mark in marks:
            mark.set_xdata([time_s, time_s])  # type: ignore[attr-defined]
        canvas.draw()
        yield Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    plt.close(figure)


def _scene(axes: Axes, traces: SessionTraces, scenario: Scenario, time_s: float) -> None:
    """Draw both sides at one instant."""
    axes.clear()
    server = traces.server
    assert server is not None
    step = int(np.searchsorted(server.time_s, time_s, side="right")) - 1
    size = float(scenario.server.object_size_m) * MM
    cube = float(server.x_o[step, 0]) * MM
    target = float(server.target[step, 0]) * MM
    wanted = Rectangle(
        (target - size / 2, SERVER - 0.26), size, 0.52, fill=False, ls=":", ec="0.4"
    )
    axes.add_patch(wanted)
    axes.add_patch(Rectangle((cube - size / 2, SERVER - 0.26), size, 0.52, fc="0.8", ec="0.3"))
    for index, user in enumerate(traces.users):
        colour = COLOURS[index]
        tick = int(np.searchsorted(user.time_s, time_s, side="right")) - 1
        device = float(user.x_m[tick, 0]) * MM
        avatar = float(server.x_s[server.users.index(user.name)][step, 0]) * MM
        force = float(user.f_applied[tick, 0])
        axes.plot([device, avatar], [HANDS, SERVER], ls="--", lw=1.0, color=colour)
        axes.plot([device], [HANDS], "o", ms=15, color=colour)
        axes.plot([avatar], [SERVER], "o", ms=8, color=colour)
        if abs(force) > 0.05:
            tip = device - force * ARROW_MM_PER_N
            arrow = {"arrowstyle": "-|>", "color": colour, "lw": 2.0}
            axes.annotate("", (tip, HANDS), (device, HANDS), arrowprops=arrow)
        ahead = abs(device - avatar)
        axes.text(device, HANDS + 0.3, f"{ahead:.1f} mm ahead", va="center", ha="center")
    axes.set(xlim=(-90, 110), ylim=(-0.45, 1.5), yticks=[HANDS, SERVER], xlabel="position [mm]")
    axes.set_yticklabels(["hands", "server"])
    axes.set_title(f"Two hands carry a cube over 16 ms: live session, {time_s:4.1f} s", loc="left")


def _forces(axes: Axes, traces: SessionTraces) -> object:
    """Draw the forces and return the mark of the present."""
    for index, user in enumerate(traces.users):
        axes.plot(user.time_s, np.abs(user.f_applied[:, 0]), color=COLOURS[index], lw=1.0)
    axes.set(xlim=(0, traces.duration_s), xlabel="time [s]", ylabel="force [N]")
    axes.set_title("forces that both hands feel", loc="left")
    return axes.axvline(0.0, color="0.3", lw=1.0)


def _energies(axes: Axes, traces: SessionTraces, scenario: Scenario) -> object:
    """Draw the energy that each link keeps and return the mark of the present."""
    for index, user in enumerate(user_energies(traces, scenario)):
        for balance, dash in ((user.up, "-"), (user.down, "--")):
            assert balance is not None
            sums = balance.balance_j * 1e3
            axes.plot(balance.time_s, sums, dash, color=COLOURS[index], lw=1.0)
    axes.axhline(0.0, color="0.3", lw=0.8)
    axes.set(xlim=(0, traces.duration_s), xlabel="time [s]", ylabel="[mJ]")
    axes.set_title("energy kept by each link: never below 0", loc="left")
    return axes.axvline(0.0, color="0.3", lw=1.0)


def write(pictures: list[Image.Image], target: Path) -> None:
    """Write an endless animation with one palette for all pictures."""
    palette = pictures[len(pictures) // 2].quantize(PALETTE)
    reduced = [one.quantize(palette=palette, dither=Image.Dither.NONE) for one in pictures]
    first, *others = reduced
    first.save(
        target,
        save_all=True,
        append_images=others,
        duration=round(1000 / FRAMES_HZ),
        loop=0,
        optimize=True,
    )


def main() -> None:
    """Record a session, or take one, and draw it."""
    parser = argparse.ArgumentParser(prog="make film")
    parser.add_argument("--folder", type=Path, help="a recorded session of carry_16ms")
    parser.add_argument("--out", type=Path, default=TARGET)
    parser.add_argument("--seconds", type=float, default=9.0)
    options = parser.parse_args()
    mpl.rcParams.update({"font.size": 9})
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch) / "session"
        if options.folder is None:
            record(folder, options.seconds)
        traces, scenario = pmwvc.read(folder)
    assert scenario is not None
    write(list(frames(traces, scenario)), options.out)
    print(f"{options.out}: {options.out.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
