# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts of couplings that use the contact force at an instant and hold it over the step.

The object goes on exactly under the held forces. (With semi-implicit or forward Euler for the
object the published stability regions do not come out.) These couplings balance energy only as the
step goes to zero; ``dissipated`` counts B |xd_s - xd_o|^2 at the instants, so what is missing in
the balance is what the computation itself makes.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from pmwvc_core.numeric import Value
from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.server.cube import Body
from pmwvc_core.server.user_ports import UserPort


def weights(integrator: str, period: float) -> tuple[float, float]:
    """Return what old and new velocity weigh [s] in the avatar's displacement over a step."""
    return {
        "forward_euler": (period, 0.0),
        "backward_euler": (0.0, period),
        "trapezoid": (0.5 * period, 0.5 * period),
    }[integrator]


def push_object(ports: Sequence[UserPort], body: Body) -> Value:
    """Let the held forces move the object; return the energy lost meanwhile [J]."""
    force: Value = 0.0
    for port in ports:
        force = force + port.f_s
    moved, lost = body.push(force)
    for port in ports:
        lost = lost + port.contact.slide(-moved)
    return lost


class Sampled(ABC):
    """A coupling that moves the object first, then every avatar by its own law."""

    def __init__(self, params: ServerParams) -> None:
        self._period = params.period_s
        self._old, self._new = weights(params.integrator, params.period_s)

    def step(self, ports: Sequence[UserPort], body: Body) -> Value:
        """Use every port's ``u_s``; return the energy dissipated [J]."""
        lost = push_object(ports, body)
        for port in ports:
            lost = self._move(port, body, lost)
        return lost

    @abstractmethod
    def _move(self, port: UserPort, body: Body, lost: Value) -> Value:
        """Set velocity and force of one port; return the energy dissipated so far [J]."""


def least_impedance(params: ServerParams, contact: ContactParams) -> float:
    """Return K T_VE + 2 B [N s/m]: the least impedance of a port that decodes a wave with the
    force of the step before and is passive at a wall (backward Euler).
    """
    stiffness, damping = float(contact.contact_stiffness), float(contact.contact_damping)
    return stiffness * params.period_s + 2.0 * damping
