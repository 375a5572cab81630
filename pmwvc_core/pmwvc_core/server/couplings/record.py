# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of a coupling: what closes the algebraic loop, and the properties that other code
asks for by name.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import Value
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.plugins import Record
from pmwvc_core.server.black_box.faults import Faults
from pmwvc_core.server.couplings.sampled import weights
from pmwvc_core.server.cube import Body
from pmwvc_core.server.user_ports import UserPort

OBJECT_MOTIONS = ("held", "held_before", "midpoint")


class LoopSolver(Protocol):
    """One step of avatars and object."""

    def step(self, ports: Sequence[UserPort], body: Body) -> Value:
        """From ``u_s`` set ``xd_s`` and ``f_s``, move all; return the energy dissipated [J]."""
        ...


@runtime_checkable
class Faulting(Protocol):
    """May be there: steps whose equation was not solved to rounding."""

    faults: Faults


def by_integrator(params: ServerParams) -> tuple[float, float]:
    """Return what old and new velocity weigh [s] by ``server.integrator``."""
    return weights(params.integrator, params.period_s)


def forward(params: ServerParams) -> tuple[float, float]:
    """Return what they weigh [s] where the avatar moves with the velocity before."""
    return params.period_s, 0.0


def backward(params: ServerParams) -> tuple[float, float]:
    """Return what they weigh [s] where the avatar moves with its new velocity."""
    return 0.0, params.period_s


def never(params: ServerParams) -> bool:
    """Return False: nothing is known."""
    return False


@dataclass(frozen=True, kw_only=True)
class Coupling(Record):
    """A coupling: what makes its solver, and its properties.

    Attributes
    ----------
    make
        Makes the solver of a step; None for a black box, and where a controller has its own.
    black_box
        Whether the environment is known by its forces only
        (:mod:`pmwvc_core.server.black_box`).
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
    object_motion
        How the object moves: under the forces of the step ``held``, under those of the step
        before (``held_before``), or by the ``midpoint`` rule.
    passive
        Tells whether the server returns no more energy than it received, whatever is touched.
    least_impedance
        Wave impedance [N s/m] from which on a contact with a wall is passive; None where no
        such bound is known or needed.
    """

    make: Callable[[ServerParams], LoopSolver] | None = None
    black_box: bool = False
    parameters: tuple[str, ...] = ()
    moves: Callable[[ServerParams], tuple[float, float]] | None = by_integrator
    balanced: bool = False
    exact: bool = False
    late: bool = False
    object_motion: str = "held_before"
    passive: Callable[[ServerParams], bool] = never
    least_impedance: Callable[[ServerParams, ContactParams], float] | None = None

    def __post_init__(self) -> None:
        """Refuse a motion that no account knows."""
        if self.object_motion not in OBJECT_MOTIONS:
            raise ParameterError(
                f"object_motion = {self.object_motion!r}: must be one of "
                f"{', '.join(OBJECT_MOTIONS)}"
            )
