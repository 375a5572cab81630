# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of a coupling: what closes the algebraic loop, and the properties that other code
asks for by name.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pmwvc_core.errors import ParameterError
from pmwvc_core.law.server.sampled import weights
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.plugins import Record

OBJECT_MOTIONS = ("held", "held_before", "midpoint")


def by_integrator(params: ServerParams) -> tuple[float, float]:
    """Return what old and new velocity weigh [s] by ``server.integrator``."""
    return weights(params.integrator, params.period_s)


def forward(params: ServerParams) -> tuple[float, float]:
    """Return what they weigh [s] where the avatar moves with the velocity before."""
    return params.period_s, 0.0


def backward(params: ServerParams) -> tuple[float, float]:
    """Return what they weigh [s] where the avatar moves with its new velocity."""
    return 0.0, params.period_s


@dataclass(frozen=True, kw_only=True)
class Coupling(Record):
    """A coupling: what makes its law, and its properties.

    Attributes
    ----------
    law
        Makes, from what old and new velocity weigh by ``server.integrator`` [s], the NamedTuple
        by whose type the family :data:`pmwvc_core.law.server.avatar.couple` chooses the law of a
        step; None for a black box (the environment is known by its forces only,
        :mod:`pmwvc_core.server.black_box`), and where a controller has its own.
    parameters
        Fields of ``server.*`` that decide what it does, as reports show them.
    moves
        What old and new velocity weigh [s] in an avatar's displacement over a step; None where
        the avatar stands at the device's position.
    balanced
        Whether velocity and force of a step belong together: F . xd = (|u|^2 - |v|^2)/2.
    exact
        Whether stored energy and heat balance the waves to rounding in every step.
    late
        Whether waves are decoded with the force of the step before, xd = sqrt(2/b) u - F'/b.
    black_box
        Whether the environment is known by its forces only.
    object_motion
        How the object moves: under the forces of the step ``held``, under those of the step
        before (``held_before``), or by the ``midpoint`` rule.
    passive
        Tells whether the server returns no more energy than it received, whatever is touched.
    least_impedance
        Wave impedance [N s/m] from which on a contact with a wall is passive; None where no
        such bound is known or needed.
    """

    law: Callable[[float, float], Any] | None = None
    parameters: tuple[str, ...] = ()
    moves: Callable[[ServerParams], tuple[float, float]] | None = by_integrator
    balanced: bool = False
    exact: bool = False
    late: bool = False
    black_box: bool = False
    object_motion: str = "held_before"
    passive: Callable[[ServerParams], bool] = lambda params: False
    least_impedance: Callable[[ServerParams, ContactParams], float] | None = None

    def __post_init__(self) -> None:
        """Refuse a motion that no account knows."""
        if self.object_motion not in OBJECT_MOTIONS:
            raise ParameterError(
                f"object_motion = {self.object_motion!r}: must be one of "
                f"{', '.join(OBJECT_MOTIONS)}"
            )
