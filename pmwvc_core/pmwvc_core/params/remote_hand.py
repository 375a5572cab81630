# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the hand whose target comes from outside."""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated, parameter


@dataclass(frozen=True)
class RemoteHandParams(Validated):
    """The arm of operator `remote` and its limits; its grip is that of any hand."""

    mass: float = parameter(0.4, "kg", "mass of the arm", low=0.05, high=10.0)
    damping: float = parameter(22.0, "N s/m", "damping of the arm", low=0.0, high=200.0)
    stiffness: float = parameter(
        300.0, "N/m", "stiffness of the arm to its target", low=1.0, high=2000.0
    )
    speed_m_s: float = parameter(
        0.5, "m/s", "fastest motion of the arm's target", above=0.0, high=1.0
    )
    reach_n: float = parameter(
        6.0,
        "N",
        "largest force of the arm's spring: its target is never further than reach_n / stiffness "
        "from the arm",
        above=0.0,
        high=20.0,
    )
    brake: float = parameter(
        5.0, "N s/m", "damping of a handle that nobody holds", low=0.0, high=20.0
    )
