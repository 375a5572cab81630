# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the server that change in flight, before a step; no energy comes or goes."""

from collections.abc import Sequence

from pmwvc_core.law.server.body import changed_body
from pmwvc_core.law.server.server_port import Environment, UserPort
from pmwvc_core.law.server_step import ServerStepParams
from pmwvc_core.law.wave.wave import Impedance, MatrixImpedance
from pmwvc_core.made.server import are_coupled, as_matrix
from pmwvc_core.made.waves import made_impedance
from pmwvc_core.scenario.scenario import User


def changed_server(s: Environment, p: ServerStepParams, q: ServerStepParams) -> Environment:
    """Go on with other parameters of object and coupling, from forces and velocities as they are.

    ``p`` are the parameters until here, ``q`` those from here on. A black box keeps its own.
    """
    if hasattr(s.body, "environment"):
        return s
    return s._replace(body=changed_body(s.body, p.environment.body, q.environment.body))


def alike(ports: tuple[UserPort, ...], users: Sequence[User]) -> tuple[UserPort, ...]:
    """Return ports with impedances of one kind: a number is a matrix while any user's is one."""
    return tuple(_alike(port, are_coupled(users)) for port in ports)


def _alike(port: UserPort, coupled: bool) -> UserPort:
    b = port.avatar.impedance
    if coupled and isinstance(b, Impedance):
        b = made_impedance(as_matrix(b.b, len(port.x_s)))
    elif not coupled and isinstance(b, MatrixImpedance):
        b = made_impedance(b.b[0][0])
    avatar = port.avatar._replace(impedance=b)
    return port._replace(avatar=avatar)
