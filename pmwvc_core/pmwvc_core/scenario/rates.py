# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rates that may change while a session runs: of packets, and of the server.

On the strict channel a packet carries the time that it stands for, so both may change with the
next frame or step. On the plain channel it stands for a fixed time, which filter, hold and the
receiver's energy rest on. A coupling that moves avatars by the velocity of the step before would
lose or make displacement where that step was shorter or longer than this one.
"""

from pmwvc_core.params import ServerParams
from pmwvc_core.server.couplings import Coupling

RATE_DROP, PERIOD = "master.rate_drop", "server.period_s"
NEEDS_STRICT = (
    "can change on the strict channel only; on the other channels a packet stands for a fixed time"
)


def why_fixed(name: str, *, strict: bool, server: ServerParams, coupling: Coupling) -> str:
    """Return why a rate (``RATE_DROP`` or ``PERIOD``) cannot change while a session runs on this
    channel, with this server and its coupling; "" where it can, as any other parameter.
    """
    if name in (RATE_DROP, PERIOD) and not strict:
        return NEEDS_STRICT
    if name == PERIOD and (coupling.moves is None or coupling.moves(server)[0] != 0.0):
        return (
            f"is fixed with server.coupling = {coupling.name}, server.integrator = "
            f"{server.integrator}: avatars move by the velocity of the step before"
        )
    return ""
