# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The walls that a method renders: the Z-width, as the share of a grid of stiffness and damping.

One hand closes on a wall and rests there. The wall is rendered if the session is stable
(:mod:`pmwvc_analysis.verdicts.stability`) and the spring of the wall keeps half of its largest
force (means of a second; a force that fades is no wall). All walls of a network meet the same
packet fates and run as one batch.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from benchmark.methods import Settings
from benchmark.trial import hands
from pmwvc_analysis.compare.measures import least_balance
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_bringup import scenarios as files
from pmwvc_core.network.effects import mean_s
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.session import simulate
from pmwvc_core.traces import SessionTraces

LINE_N_S_M = 10.0  # damping on which the largest stiffness is looked for, in fine steps
WALL_S, ROUND_TRIPS = 6.0, 8.0  # duration of a session at the wall, and for each round trip more
KEEPS = 0.5
Wall = tuple[float, float]  # stiffness [N/m], damping [N s/m]


@dataclass(frozen=True)
class Grid:
    """The walls to look at: stiffnesses in fine steps, on the line; every so many of them with
    each damping.
    """

    fine_n_m: tuple[float, ...]
    every: int
    dampings_n_s_m: tuple[float, ...]


GRID = Grid(tuple(np.geomspace(10.0, 20000.0, 65)), 8, (1.0, 3.2, 10.0, 32.0, 100.0))  # 13 % steps


@dataclass(frozen=True)
class Walls:
    """The walls rendered: share of all, of those with all ports passive, and the end of a
    range of stiffnesses that begins at the softest [N/m]; 0: not even that.
    """

    rendered: float
    rendered_passive: float
    stiffness_max_n_m: float


def walls(settings: Settings, network: str, seed: int, of: Grid = GRID) -> Walls:
    """Run all walls of a method on a network, with the hand and packet fates of a seed."""
    grid = [(k, b) for b in of.dampings_n_s_m for k in of.fine_n_m[:: of.every]]
    line = [(k, LINE_N_S_M) for k in of.fine_n_m]
    found = _rest(list(dict.fromkeys((*grid, *line))), settings, network, seed)
    held = [*(found[each].rests for each in line), False].index(False)
    return Walls(
        rendered=float(np.mean([found[each].rests for each in grid])),
        rendered_passive=float(np.mean([found[w].rests and found[w].passive for w in grid])),
        stiffness_max_n_m=float(of.fine_n_m[held - 1]) if held else 0.0,
    )


def wall(settings: Settings, network: str, seed: int, duration_s: float) -> Scenario:
    """Return the scenario of one hand at a wall."""
    texts = (f"link.preset={network}", f"seed={seed}", *settings)
    return files.load("wall", settings_texts=texts, duration_s=duration_s)


class _Rest(NamedTuple):
    rests: bool
    passive: bool


def _rest(grid: list[Wall], settings: Settings, network: str, seed: int) -> dict[Wall, _Rest]:
    """Return what becomes of a hand at each wall, given by stiffness and damping."""
    own = tuple(text for text in hands(seed) if text.startswith("operator."))
    first = wall(settings, network, seed, WALL_S).users[0]
    duration_s = WALL_S + ROUND_TRIPS * (mean_s(first.link_up) + mean_s(first.link_down))
    scenarios = [
        wall(
            (*settings, *own, f"server.contact_stiffness={k:.6g}", f"server.contact_damping={b}"),
            network,
            seed,
            duration_s,
        )
        for k, b in grid
    ]
    traces = simulate(scenarios)
    return {
        each: _Rest(
            keeps_pressing(one, damping_n_s_m=each[1]) and verdict(one, scenario).stable is True,
            least_balance(one, scenario)["passive"] is True,
        )
        for each, scenario, one in zip(grid, scenarios, traces, strict=True)
    }


def keeps_pressing(traces: SessionTraces, *, damping_n_s_m: float) -> bool:
    """Tell whether the spring of the wall has half of its largest force in the last second, or
    more.
    """
    server = traces.server
    if server is None:
        return False
    second = round(1.0 / server.period_s)
    spring = np.abs(server.f_s[0][:, 0]) - damping_n_s_m * server.xd_s[0][:, 0]
    spring[~server.contact[0]] = 0.0
    means = spring[: len(spring) // second * second].reshape(-1, second).mean(axis=1)
    return bool(means[-1] > 0.0 and means[-1] >= KEEPS * means.max())
