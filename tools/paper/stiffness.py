# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figure: the stiffness felt of a wall of 2000 N/m (damping 10 N s/m) against the mass of the link
in free motion, device left out, at several delays, and what linear time-invariant links can do at
best: a link K_ch = 4 M/tau^2 in series with the wall, tau the round trip of the network alone.
"""

import math
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from typing import NamedTuple

import numpy as np

from paper.drawing import COLOURS, MARKS, Rows, panels, save
from pmwvc_analysis.compare.probes import free_space
from pmwvc_bringup import scenarios as files
from pmwvc_core.scenario.scenario import PARAMETERS, Scenario
from pmwvc_core.simulation.conditions import place_of
from pmwvc_core.simulation.session import simulate_one

NAME = "stiffness"
WALL_N_M = 2000.0
DELAYS_S = (0.008, 0.016, 0.024, 0.05)
HAND = ("operator.stiffness=120", "operator.damping=15", "operator.squeeze=2")
DURATION_S, AT_REST = 15.0, 0.05  # motion in the last second, of the depth
LOAN = ("master.position.gain=20", "master.position.storage_j=0.02")
FOLLOWS = ("master.impedance=8", "master.contact_impedance=90")
SETTINGS = (  # what is drawn, and its settings; those with unknown parameters are left out
    ("plain", ("channel=plain",)),
    ("strict", ("channel=strict",)),
    ("strict, loan", ("channel=strict", *LOAN)),
    ("strict, b follows contact", ("channel=strict", *FOLLOWS)),
    ("strict, both", ("channel=strict", *FOLLOWS, *LOAN)),
)


class Felt(NamedTuple):
    """Stiffness felt [N/m], mass of the link [kg]; NaN: not at rest, or unknown."""

    stiffness_n_m: float
    mass_kg: float


def known(settings: tuple[str, ...]) -> bool:
    """Tell whether the product has the parameters of some settings."""
    names = {text.partition("=")[0] for text in settings} - {"channel"}
    return names <= set(PARAMETERS)


def wall(settings: tuple[str, ...], delay_s: float) -> Scenario:
    """Return the session of one hand at the wall."""
    the_wall = (f"server.contact_stiffness={WALL_N_M}", "server.contact_damping=10")
    texts = (*the_wall, f"link.delay_s={delay_s}", *settings)
    return files.load("wall", settings_texts=texts, duration_s=DURATION_S)


def felt(of: tuple[tuple[str, tuple[str, ...]], float]) -> Felt:
    """Measure both, of one setting at one delay."""
    (_, settings), delay_s = of
    free = free_space(wall(settings, delay_s))
    scenario = wall((*settings, *HAND), delay_s)
    mass = free.mass_kg - float(scenario.users[0].device.mass) if free else math.nan
    return Felt(rested(scenario), mass)


def rested(scenario: Scenario) -> float:
    """Return the stiffness of the wall under a hand that rests on it, in the last second [N/m];
    NaN where the device still moves.
    """
    traces, of = simulate_one(scenario), scenario.users[0]
    user, face_m = traces.users[0], of.side * place_of(of, scenario).half_width_m
    late = user.time_s >= scenario.duration_s - 1.0
    depth = of.side * (face_m - user.x_m[late, 0])
    force = -of.side * user.f_applied[late, 0]
    if np.ptp(depth) > AT_REST * depth.mean():
        return math.nan
    return float(force.mean() / depth.mean())


def make() -> Rows:
    """Draw, and return the numbers."""
    cases = list(product([each for each in SETTINGS if known(each[1])], DELAYS_S))
    with ProcessPoolExecutor(2) as pool:
        results = dict(zip(cases, pool.map(felt, cases), strict=True))
    figure, (axes,) = panels(1, 1, 3.6)
    masses = np.geomspace(0.05, 3.0, 100)
    numbers = [["settings", *(f"{1e3 * delay_s:g} ms" for delay_s in DELAYS_S)]]
    for delay_s in DELAYS_S:
        bound = 4.0 * masses / (2.0 * delay_s) ** 2
        most = 1.0 / (1.0 / bound + 1.0 / WALL_N_M)
        axes.plot(masses, most, "k", lw=0.8)
        axes.annotate(f"{1e3 * delay_s:g} ms", (masses[-1], most[-1]), fontsize=7)
    for index, each in enumerate(dict.fromkeys(case[0] for case in cases)):
        found = [results[each, delay_s] for delay_s in DELAYS_S]
        axes.plot(
            [one.mass_kg for one in found], [one.stiffness_n_m for one in found],
            MARKS[index], ls=":", color=COLOURS[index], label=each[0],
        )  # fmt: skip
        for delay_s, one in zip(DELAYS_S, found, strict=True):
            place = one.mass_kg, one.stiffness_n_m
            axes.annotate(f" {1e3 * delay_s:g}", place, fontsize=6, color=COLOURS[index])
        cells = [_cell(one, delay_s) for delay_s, one in zip(DELAYS_S, found, strict=True)]
        numbers.append([each[0], *cells])
    axes.set(xscale="log", xlabel="mass of the link in free motion [kg]",
             ylabel="stiffness felt of 2000 N/m", ylim=(0.0, 2150.0))  # fmt: skip
    figure.legend(loc="outside upper center", ncols=3)
    save(figure, NAME)
    return numbers


def of_bound(one: Felt, delay_s: float) -> float:
    """Return K/M of the link itself as a part of 4/tau^2; infinite: it gives way by nothing."""
    give = 1.0 / one.stiffness_n_m - 1.0 / WALL_N_M
    stiffness = 1.0 / give if give > 1e-6 else math.inf
    return stiffness / one.mass_kg * delay_s**2


def _cell(one: Felt, delay_s: float) -> str:
    beyond = of_bound(one, delay_s)
    times = f"{beyond:.2f}" if math.isfinite(beyond) else "beyond"
    return f"{one.stiffness_n_m:.0f} N/m, {one.mass_kg:.2f} kg, {times}"
