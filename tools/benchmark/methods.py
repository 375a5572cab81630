# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The methods compared, and the parameters that the search may choose for each.

Every method searches the time of silence of the watchdog beside its own parameters; direct
coupling has none of its own (the contact is the task's). A controller of another package is a
method where the module of its record has ``RANGES``, the ranges of its parameters: those of
:mod:`benchmark.rivals`, and whatever a laboratory has installed.
"""

import importlib
from dataclasses import dataclass

from benchmark.cost import drawn
from pmwvc_core.controllers.library import RECORDS
from pmwvc_core.plugins import installed

Settings = tuple[str, ...]  # name=value texts, as for --set
SILENCE = ("safety.timeout_s", 0.03, 0.5)
IMPEDANCE = ("master.impedance", 5.0, 60.0)
# One in free motion and one in contact, from those of ``master.preset=firm`` on.
TWO = (("master.impedance", 5.0, 12.0), ("master.contact_impedance", 12.0, 90.0))
WAVES = (IMPEDANCE, ("master.position.gain", 0.1, 40.0), SILENCE)
# With a loan, the gain of the strict channel follows from the round trip: nothing to search.
STRICT = (
    "controller=pmwvc",
    "channel=strict",
    "master.position.adapts=true",
    "master.position.storage_j=0.005",
)


# Of controllers without waves: least and largest value searched, by parameter.
OWN = {
    "virtual_coupling": {"stiffness": (30.0, 2000.0), "damping": (0.3, 15.0)},
    "tdpa": {
        "damping": (0.3, 20.0), "damping_max": (5.0, 100.0), "fade_s": (1e-3, 0.05),
        "drift_share": (0.01, 0.5),
    },
    "pspm": {
        "stiffness": (50.0, 3000.0), "damping": (0.3, 10.0), "initial_j": (2e-3, 0.2),
        "cap_j": (2e-3, 0.2),
    },
}  # fmt: skip


@dataclass(frozen=True)
class Method:
    """A method: name, what selects it, and the range of each parameter searched (logarithmic)."""

    name: str
    settings: Settings
    ranges: tuple[tuple[str, float, float], ...]

    def candidates(self, count: int, seed: int) -> list[Settings]:
        """Return settings to try: the defaults, then random ones, the same for the same seed."""
        ranges = {name: (low, high) for name, low, high in self.ranges}
        return [
            (*self.settings, *(f"{name}={value:.3g}" for name, value in values.items()))
            for values in drawn(self.name, ranges, count, seed)
        ]


def _baseline(name: str) -> Method:
    """Return a controller without waves as a method."""
    own = OWN.get(name, {}).items()
    ranges = ((f"baseline.{name}.{leaf}", low, high) for leaf, (low, high) in own)
    return Method(name, (f"controller={name}",), (*ranges, SILENCE))


def _installed() -> list[Method]:
    """Return the controllers of other packages that say what may be searched."""
    found = []
    for name, point in installed(RECORDS.plugins.group).items():
        own = getattr(importlib.import_module(point.module), "RANGES", {})
        ranges = tuple((f"{name}.{leaf}", low, high) for leaf, (low, high) in own.items())
        if own:
            found.append(Method(name, (f"controller={name}",), (*ranges, SILENCE)))
    return found


METHODS = {
    method.name: method
    for method in (
        Method("strict", STRICT, (IMPEDANCE, SILENCE)),
        Method("strict_following", (*STRICT, "master.preset=firm"), (*TWO, SILENCE)),
        Method("plain", ("controller=pmwvc", "channel=plain"), WAVES),
        Method("zeroing", ("controller=pmwvc", "channel=zeroing"), WAVES),
        *map(_baseline, ("direct", "virtual_coupling", "tdpa", "pspm")),
        *_installed(),
    )
}
