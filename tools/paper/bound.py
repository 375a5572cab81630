# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Figure: what random passive links render at a wall over what they render in free motion, against
the bound, and links that generate energy, against it too.
"""

import numpy as np

from paper.drawing import COLOURS, Rows, panels, save
from paper.links import Array, bound, random_link, wave_variables

NAME = "bound"
LINKS, CHEATS, SHOWN, PLACES = 4000, 1000, 1500, 12
GAIN = 1.2  # of the junctions of links that generate energy


def found(count: int, gain: float, seed: int) -> tuple[Array, Array]:
    """Return s tau of random links, and the ratio there of each ``(links, places)``."""
    rng = np.random.default_rng(seed)
    places = 10.0 ** rng.uniform(-1.5, 1.0, (count, PLACES))
    ratios = np.zeros_like(places)
    for row, at in zip(ratios, places, strict=True):
        link = random_link(rng, gain)
        row[:] = [link.ratio(place / link.round_trip_s) for place in at]
    return places, ratios


def make() -> Rows:
    """Draw, and return the numbers."""
    places, ratios = found(LINKS, 1.0, 1)
    of_cheats, cheated = found(CHEATS, GAIN, 2)
    limit = np.vectorize(bound)
    share = ratios / limit(places, 1.0)
    beyond = (cheated / limit(of_cheats, 1.0) > 1.0 + 1e-9) | (cheated < 0.0)
    figure, (axes,) = panels(1, 1, 3.2)
    x = np.geomspace(places.min(), places.max(), 200)
    violet, red = COLOURS[0], COLOURS[1]
    shown = slice(SHOWN)
    axes.plot(places[shown].flat, ratios[shown].flat, ".", ms=1.6, color=violet, alpha=0.5,
              label=f"{LINKS} random passive links", rasterized=True)  # fmt: skip
    over = of_cheats[beyond & (cheated > 0)], cheated[beyond & (cheated > 0)]
    axes.plot(*over, "x", ms=3.0, color=red, label="links that generate energy, beyond it",
              rasterized=True)  # fmt: skip
    axes.plot(x, limit(x, 1.0), color="black", label="bound, coth²(s τ/2)")
    link = wave_variables(1.0)
    at = np.geomspace(x[0], x[-1], 15)
    axes.plot(at, [link.ratio(s) for s in at], "o", mfc="none", color="black", ms=5.0,
              label="wave variables")  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel="s τ", ylabel="Z wall / Z free", ylim=(0.5, 3e3))
    axes.legend(loc="upper right")
    save(figure, NAME)
    of_waves = max(link.ratio(s) / bound(s, 1.0) for s in at)
    return [
        ["links", "largest part of the bound reached"],
        [f"{LINKS} random passive ones", f"{share.max():.4f}"],
        ["wave variables", f"{of_waves:.4f}"],
        [
            f"{CHEATS} random ones that generate energy",
            f"beyond it: {100 * beyond.any(axis=1).mean():.0f} % of them",
        ],
    ]
