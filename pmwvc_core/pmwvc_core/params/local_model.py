# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the local model that answers the high-pass wave of a filter bank (App. E)."""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated, parameter

PLACES = ("everywhere", "above", "below")


@dataclass(frozen=True)
class LocalModelParams(Validated):
    """A spring and damper to ground, or a model that is a plug-in."""

    kind: str = parameter(
        "spring_damper",
        "-",
        "spring_damper, or the name of an entry point in the group pmwvc.local_models",
        read_only=True,
    )
    stiffness: float = parameter(500.0, "N/m", "spring_damper: stiffness", low=0.0, high=1e6)
    damping: float = parameter(1.0, "N s/m", "spring_damper: damping", low=0.0, high=1e4)
    acts: str = parameter(
        "everywhere",
        "-",
        "where there is something to touch: above, below: only while the device is above or "
        "below begins_m along axis 0",
        choices=PLACES,
    )
    begins_m: float = parameter(
        0.0, "m", "position of the device at which it begins", low=-10.0, high=10.0
    )
