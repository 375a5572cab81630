# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The walls that a method renders: the Z-width, as the share of a grid of stiffness and damping.

One hand closes on a wall and rests there. The wall is rendered if the session is stable
(:mod:`pmwvc_analysis.verdicts.stability`) and the spring of the wall keeps half of its largest
force (means of a second; a force that fades is no wall). All walls of a network meet the same
packet fates.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from benchmark.fast import simulated
from benchmark.methods import Settings
from benchmark.tasks import hands
from pmwvc_analysis.compare.measures import least_balance
from pmwvc_analysis.verdicts.stability import verdict
from pmwvc_bringup import scenarios as files
from pmwvc_core.network.effects import mean_s
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces

WALL_S, ROUND_TRIPS = 6.0, 8.0  # duration of a session at the wall, and for each round trip more
KEEPS = 0.5


class Grid(NamedTuple):
    """The walls to look at."""

    stiffnesses_n_m: tuple[float, ...]
    dampings_n_s_m: tuple[float, ...]


GRID = Grid(tuple(np.geomspace(10.0, 20000.0, 9).tolist()), (1.0, 10.0, 100.0))  # each 2.6 times


@dataclass(frozen=True)
class Asked:
    """A measurement to make: a method on a network, with the walls of a grid."""

    method: str
    settings: Settings
    network: str
    seed: int
    grid: Grid = GRID


@dataclass(frozen=True)
class Walls:
    """The walls rendered: share of all, of those with all ports passive, and the end of a
    range of stiffnesses that begins at the softest, all dampings rendered [N/m]; 0: not even that.
    """

    rendered: float
    rendered_passive: float
    stiffness_max_n_m: float


def walls(asked: Asked, *, compiled: bool = False) -> Walls:
    """Run all walls of a method on a network, with the hand and packet fates of a seed."""
    of = asked.grid
    found = np.array(
        [
            [_rest(asked, k, b, compiled=compiled) for b in of.dampings_n_s_m]
            for k in of.stiffnesses_n_m
        ]
    )
    held = [*(bool(row.all()) for row in found[..., 0]), False].index(False)
    return Walls(
        rendered=float(found[..., 0].mean()),
        rendered_passive=float(found.all(axis=-1).mean()),
        stiffness_max_n_m=float(of.stiffnesses_n_m[held - 1]) if held else 0.0,
    )


def wall(settings: Settings, network: str, seed: int, duration_s: float) -> Scenario:
    """Return the scenario of one hand at a wall."""
    texts = (f"link.preset={network}", f"seed={seed}", *settings)
    return files.load("wall", settings_texts=texts, duration_s=duration_s)


def _rest(asked: Asked, stiffness: float, damping: float, *, compiled: bool) -> tuple[bool, bool]:
    """Return whether a wall is rendered, and whether all ports are passive."""
    of = asked.network, asked.seed
    own = tuple(text for text in hands("carry", asked.seed) if text.startswith("operator."))
    texts = f"server.contact_stiffness={stiffness:.6g}", f"server.contact_damping={damping:g}"
    first = wall(asked.settings, *of, WALL_S).users[0]
    duration_s = WALL_S + ROUND_TRIPS * (mean_s(first.link_up) + mean_s(first.link_down))
    scenario = wall((*asked.settings, *own, *texts), *of, round(duration_s, 3))
    traces = simulated(scenario, compiled=compiled)
    keeps = keeps_pressing(traces, damping_n_s_m=damping)
    rests = keeps and verdict(traces, scenario).stable is True
    return rests, least_balance(traces, scenario)["passive"] is True


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
