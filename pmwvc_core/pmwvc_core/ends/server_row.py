# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server after a step, as observers see it."""

from collections.abc import Sequence

from pmwvc_core.ends.forms import value
from pmwvc_core.frame.rows import PortRow, Presence, ServerRow
from pmwvc_core.law.server.energies import PortShown, environment_energies, port_shown
from pmwvc_core.law.server.server_port import UserPort
from pmwvc_core.law.server_step import Server, ServerStepParams
from pmwvc_core.numeric import Value

PRESENCES = tuple(Presence)  # by their numbers, which are those of the law


def row_of(s: Server, p: ServerStepParams, accounts: Sequence[str], target_m: Value) -> ServerRow:
    """Return the server as it is now, with the energies that its environment counts by name."""
    e = s.environment
    kinetic, potential, *energies = environment_energies(p.environment, e)
    shown = [port_shown(p.environment, e, user) for user in range(len(e.ports))]
    return ServerRow(
        value(e.body.x),
        value(e.body.xd),
        target_m,
        kinetic,
        potential,
        e.dissipated_j,
        [_port(port, seen) for port, seen in zip(e.ports, shown, strict=True)],
        tuple(PRESENCES[guest.presence] for guest in s.guests),
        dict(zip(accounts, energies, strict=False)),
    )


def _port(port: UserPort, shown: PortShown) -> PortRow:
    a = port.avatar
    return PortRow(
        value(port.x_s),
        value(a.xd),
        value(a.f),
        value(a.u),
        value(shown.v_s),
        port.sums.u_j,
        port.sums.v_j,
        shown.touches,
    )
