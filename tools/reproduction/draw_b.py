# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of App. B."""

from typing import Any

from reproduction.drawing import OBJECT, colour_of, numbers, region, sheet
from reproduction.figure import Values


def _delay(frames: int) -> str:
    return {0: "0", 1: "T_n"}.get(frames, f"{frames}T_n")


def waves(result: Values) -> Any:
    """Fig. 2: rows are delays, columns filters."""
    given = result["parameters"]
    delays, poles = given["delay_frames"], given["pole_rad_s"]
    figure, axes = sheet(result, len(delays), len(poles), size_in=(7.2, 13.0))
    letters = iter("abcdefgh")
    for row, delay in enumerate(delays):
        for column, pole in enumerate(poles):
            panel = axes[row, column]
            region(panel, result["data"][f"{pole:g}/{delay}"])
            panel.set_title(
                f"({next(letters)}) $T_d = {_delay(delay)}$, $f_{{c{column + 1}}} = {pole:g}$"
            )
            panel.set_xlabel("$K_1$ [N/m]")
            panel.set_ylabel("$K_2$ [N/m]")
    return figure


def direct(result: Values) -> Any:
    """Fig. 3: one panel a delay."""
    delays = result["parameters"]["delay_frames"]
    figure, axes = sheet(result, 2, 2, size_in=(7.2, 7.6))
    for panel, delay in zip(axes.ravel(), delays, strict=True):
        region(panel, result["data"][str(delay)])
        panel.set_title(f"$T_d = {_delay(delay)}$")
        panel.set_xlabel("$K_1$ [N/m]")
        panel.set_ylabel("$K_2$ [N/m]")
    return figure


def experiment(result: Values) -> Any:
    """Fig. 5: positions and forces, one row a delay."""
    return _traces(result, path=False)


def carry(result: Values) -> Any:
    """Fig. 6: the same, with the cube and the path."""
    return _traces(result, path=True)


def _traces(result: Values, *, path: bool) -> Any:
    delays = result["parameters"]["delay_frames"]
    figure, axes = sheet(result, len(delays), 2, size_in=(11.0, 9.5))
    letters = iter("abcdef")
    for row, delay in enumerate(delays):
        data = {name: numbers(values) for name, values in result["data"][str(delay)].items()}
        time_s, (left, right) = data["time_s"], axes[row]
        for user in (1, 2):
            colour = colour_of(user - 1)
            left.plot(time_s, data[f"x_{user}_mm"], color=colour, label=f"$x_{user}$")
            left.plot(time_s, data[f"x_s{user}_mm"], ":", color=colour, label=f"$x_{{s{user}}}$")
            right.plot(time_s, data[f"f_{user}_n"], color=colour, label=f"$f_{user}$")
            right.plot(time_s, data[f"f_s{user}_n"], ":", color=colour, label=f"$f_{{s{user}}}$")
        if path:
            left.plot(time_s, data["x_o_mm"], color=OBJECT, label="cube")
            left.plot(time_s, data["target_mm"], "--", color=OBJECT, label="path")
        milliseconds = delay * 8
        left.set_title(
            f"({next(letters)}) Positions: devices solid, avatars dotted. "
            f"$T_d = {milliseconds}$ ms"
        )
        right.set_title(
            f"({next(letters)}) Forces: devices solid, avatars dotted. $T_d = {milliseconds}$ ms"
        )
        left.set_ylabel("position [mm]")
        right.set_ylabel("force [N]")
        for panel in (left, right):
            panel.set_xlabel("time [s]")
            panel.set_xlim(0.0, time_s[-1])
            if row == 0:
                panel.legend(loc="center right", ncols=2)
        if path and row == 0:
            left.legend(loc="upper left", ncols=6, columnspacing=1.0)
            left.set_ylim(-45.0, 110.0)
    return figure
