# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Ways of closing the algebraic loop between wave port and contact, by name, one file each.

The velocity of an avatar depends on the force of its contact and the force on the velocity. A
coupling says how the two are made to fit in a step of the environment.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from pmwvc_core.numeric import Value
from pmwvc_core.params import ServerParams
from pmwvc_core.server.couplings.implicit import Implicit
from pmwvc_core.server.couplings.one_frame_late import OneFrameLate
from pmwvc_core.server.couplings.one_step_delay import OneStepDelay
from pmwvc_core.server.couplings.unwrapped import Unwrapped
from pmwvc_core.server.cube import Body
from pmwvc_core.server.user_ports import UserPort

__all__ = ["COUPLINGS", "Coupling", "Implicit", "OneFrameLate", "OneStepDelay", "Unwrapped"]


class Coupling(Protocol):
    """One step of avatars and object."""

    def step(self, ports: Sequence[UserPort], body: Body) -> Value:
        """From ``u_s`` set ``xd_s`` and ``f_s``, move all; return the energy dissipated [J]."""
        ...


COUPLINGS: Mapping[str, Callable[[ServerParams], Coupling]] = {
    "implicit": Implicit,
    "one_step_delay": OneStepDelay,
    "one_frame_late": OneFrameLate,
    "unwrapped": Unwrapped,
}
