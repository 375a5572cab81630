# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The methods compared, and the parameters that the search may choose for each.

Every method searches the time of silence of the watchdog beside its own parameters; direct
coupling has none of its own (the contact is the task's).
"""

import zlib
from dataclasses import dataclass

import numpy as np

from pmwvc_core.numeric import Array

Settings = tuple[str, ...]  # name=value texts, as for --set
SILENCE = ("safety.timeout_s", 0.03, 0.5)
WAVES = (("master.impedance", 5.0, 60.0), ("master.position.gain", 0.1, 40.0), SILENCE)


@dataclass(frozen=True)
class Method:
    """A method: name, what selects it, and the range of each parameter searched (logarithmic)."""

    name: str
    settings: Settings
    ranges: tuple[tuple[str, float, float], ...]

    def candidates(self, count: int, seed: int) -> list[Settings]:
        """Return settings to try: the defaults, then random ones, the same for the same seed."""
        rng = np.random.default_rng((seed, zlib.crc32(self.name.encode())))
        drawn = rng.random((count - 1, len(self.ranges)))
        return [self.settings, *(self._at(row) for row in drawn)]

    def _at(self, row: Array) -> Settings:
        chosen = (
            f"{name}={low * (high / low) ** share:.3g}"
            for (name, low, high), share in zip(self.ranges, row, strict=True)
        )
        return (*self.settings, *chosen)


def _baseline(name: str, *ranges: tuple[str, float, float]) -> Method:
    own = tuple((f"baseline.{name}.{leaf}", low, high) for leaf, low, high in ranges)
    return Method(name, (f"controller={name}",), (*own, SILENCE))


METHODS = {
    method.name: method
    for method in (
        Method("strict", ("controller=pmwvc", "channel=strict"), WAVES),
        Method("plain", ("controller=pmwvc", "channel=plain"), WAVES),
        Method("zeroing", ("controller=pmwvc", "channel=zeroing"), WAVES),
        _baseline("direct"),
        _baseline("virtual_coupling", ("stiffness", 30.0, 2000.0), ("damping", 0.3, 15.0)),
        _baseline(
            "tdpa",
            ("damping", 0.3, 20.0),
            ("damping_max", 5.0, 100.0),
            ("fade_s", 1e-3, 0.05),
            ("drift_share", 0.01, 0.5),
        ),
        _baseline(
            "pspm",
            ("stiffness", 50.0, 3000.0),
            ("damping", 0.3, 10.0),
            ("initial_j", 2e-3, 0.2),
            ("cap_j", 2e-3, 0.2),
        ),
    )
}
