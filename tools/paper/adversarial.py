# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figure: the least energy balance of the playouts over adversarial networks, against the energy
E0 stored in each at the start. Half of the networks are drawn at random, the other half are those
of the worst so far, changed a little: a search for the worst.
"""

from typing import NamedTuple

import numpy as np
from benchmark.fast import simulated

from paper.drawing import COLOURS, Rows, panels, save
from pmwvc_analysis.budget.energy import user_energies
from pmwvc_bringup import scenarios as files

NAME = "adversarial"
STORES_MJ = (0.0, 0.5, 1.0, 2.0, 4.0)
SESSIONS = 400  # of each store
DURATION_S = 4.0
RANGES = {  # of each parameter of the network; those from 1e-3 on are drawn by their logarithms
    "delay_s": (0.0, 0.05),
    "jitter_s": (0.0, 0.04),
    "loss": (0.0, 0.5),
    "ge_p": (0.0, 0.2),
    "ge_r": (0.05, 1.0),
    "duplicate": (0.0, 0.3),
    "reorder": (0.0, 0.5),
}
OUTAGES = (0.02, 0.5), (0.005, 0.1)  # again and again: how far apart, and how long [s]
HAND = {"operator.frequency_hz": (0.5, 8.0), "operator.force": (1.0, 6.0)}
Point = dict[str, float]


class Worst(NamedTuple):
    """The minimum balance of a session's playouts [J], beside what was sent to them."""

    least_j: float
    received_j: float


def balance(point: Point, store_j: float, seed: int) -> Worst:
    """Run one hand that shakes a wall over a network."""
    apart_s, long_s = point["apart_s"], point["long_s"]
    outages = f"{apart_s:.6g} outage; {apart_s + long_s:.6g} base; "
    outages += f"{2.0 * apart_s + long_s:.6g} repeat"
    texts = [f"{name}={value:.6g}" for name, value in point.items() if "." in name]
    texts += [f"link.schedule={outages}"]
    texts += [f"seed={seed}", "channel=strict", "operator.kind=sinusoid", "link.keep_order=false"]
    texts += ["task.kind=free", "server.gap_m=0.002", "server.contact_stiffness=2000"]
    texts += [f"master.store_j={store_j}", f"server.store_j={store_j}"]
    scenario = files.load("wall", settings_texts=texts, duration_s=DURATION_S)
    (user,) = user_energies(simulated(scenario, compiled=True), scenario)
    ways = [way for way in (user.up, user.down) if way is not None]
    worst = min(ways, key=lambda way: way.minimum_j)
    return Worst(worst.minimum_j, float(worst.energy_in_j[-1]))


def drawn(rng: np.random.Generator) -> Point:
    """Return a network and a hand at random."""
    ranges = {f"link.{name}": each for name, each in RANGES.items()} | HAND
    ranges |= dict(zip(("apart_s", "long_s"), OUTAGES, strict=True))
    return {name: float(rng.uniform(*each)) for name, each in ranges.items()}


def near(point: Point, rng: np.random.Generator) -> Point:
    """Return a network and a hand near to others."""
    other = drawn(rng)
    return {name: 0.7 * value + 0.3 * other[name] for name, value in point.items()}


def searched(store_mj: float) -> list[Worst]:
    """Return the balances of all sessions of a store."""
    rng = np.random.default_rng(round(1e3 * store_mj))
    tried: list[tuple[Worst, Point, int]] = []
    for number in range(SESSIONS):
        point, seed = drawn(rng), number
        if number >= SESSIONS // 2:
            _, worst, seed = min(tried, key=lambda one: one[0].least_j)
            point = near(worst, rng)
        tried.append((balance(point, 1e-3 * store_mj, seed), point, seed))
    return [each for each, _, _ in tried]


def make() -> Rows:
    """Draw, and return the numbers."""
    figure, (axes,) = panels(1, 1, 2.8)
    least = {}
    for store_mj in STORES_MJ:
        found = searched(store_mj)
        values = [1e3 * one.least_j for one in found]
        axes.plot([store_mj] * len(values), values, "o", mfc="none", ms=4, color=COLOURS[0])
        least[store_mj] = min(values)
    axes.plot(STORES_MJ, [-each for each in STORES_MJ], "k", lw=1.0, label="-E0")
    axes.set(xlabel="energy stored in each playout at the start, E0 [mJ]",
             ylabel="minimum balance [mJ]")  # fmt: skip
    axes.legend()
    save(figure, NAME)
    return [
        ["E0 [mJ]", f"minimum balance of {SESSIONS} sessions [mJ]"],
        *([f"{each:g}", f"{value:.3f}"] for each, value in least.items()),
    ]
