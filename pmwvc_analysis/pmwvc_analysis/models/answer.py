# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The stability of one scenario by the exact model: as numbers, and in sentences."""

import math
from functools import lru_cache
from typing import Any, NamedTuple

from pmwvc_analysis.models import stability
from pmwvc_analysis.models.linear import notes_of
from pmwvc_analysis.models.linearize import stable
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.words import count


class Exact(NamedTuple):
    """Stability by the exact model."""

    spectral_radius: float  # per hyperperiod
    growth_per_s: float | None  # of the slowest motion, negative: decay; None: nothing moves
    rigid_body_modes: int  # taken out of the states
    states: int
    hyperperiod_ticks: int

    @property
    def stable(self) -> bool:
        """Tell whether nothing grows."""
        return bool(stable(self.spectral_radius))


@lru_cache(maxsize=64)
def exact(scenario: Scenario, *, live: bool) -> Exact:
    """Return the stability of a scenario; NonlinearError, or UnknownError for too much work."""
    model = stability.model_of(scenario, live=live)
    radius, hyperperiod_s = float(model.radii()[0]), model.ticks * scenario.tick_s
    growth_per_s = math.log(radius) / hyperperiod_s if radius else None
    return Exact(radius, growth_per_s, model.motions, model.count, model.ticks)


limit_of = lru_cache(maxsize=64)(stability.k_max)  # numbers and sentences ask for it


def answer(scenario: Scenario, *, live: bool = False) -> dict[str, Any]:
    """Return the document of ``--json``: ``k_max`` is None where nothing up to ``k_max_bound`` is
    unstable, unless ``k_max_unknown`` says why; ``islands`` are stable ranges above.
    """
    found, limit = exact(scenario, live=live), limit_of(scenario, live=live)
    return {
        "scenario": scenario.name,
        "live": live,
        "stable": found.stable,
        **found._asdict(),
        "k_max": limit.first,
        "k_max_bound": limit.bound,
        "k_max_unknown": limit.unknown,
        "islands": [list(island) for island in limit.islands],
        "notes": notes_of(scenario),
    }


def sentences(scenario: Scenario, *, live: bool) -> list[str]:
    """Return the same in words."""
    found, limit = exact(scenario, live=live), limit_of(scenario, live=live)
    word = "stable" if found.stable else "NOT stable"
    lines = [f"{scenario.name}: {word}, spectral radius {found.spectral_radius:.7g}"]
    if found.growth_per_s is not None:
        lines.append(f"  slowest motion: growth rate {found.growth_per_s:.3g} 1/s")
    lines.append(f"  {limit.text}")
    lines += [f"  stable again from {a:.1f} to {b:.1f} N/m" for a, b in limit.islands]
    lines.append(
        f"  model: {count(found.states, 'state')}, hyperperiod of "
        f"{count(found.hyperperiod_ticks, 'tick')}, "
        f"{count(found.rigid_body_modes, 'rigid-body mode')} removed"
    )
    return lines + [f"  note: {note}" for note in notes_of(scenario)]
