# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that change during a session in virtual time.

A group of parameters that has not changed is the same object as before; only others are handed
over. A link as recorded stays as it is.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.user import SimulatedUser


def hand_over(
    users: Sequence[SimulatedUser],
    server: Any,
    old: Scenario,
    new: Scenario,
    lasts: Callable[[float], float],
) -> None:
    """Hand new parameters to users and server; ``lasts`` tells how long the server's next step
    lasts with another period [s].
    """
    params = new.server
    if params is not old.server:
        server.hand_over(lambda: server.configure(params, first_s=lasts(params.period_s)))
    for index, (user, one, other) in enumerate(zip(users, old.users, new.users, strict=True)):
        _change_user(user, one, other)
        if other.contact is not one.contact:
            port = index, other.contact, other.server_impedance
            server.hand_over(partial(server.configure_user, *port))


def _change_user(user: SimulatedUser, old: User, new: User) -> None:
    """Hand a user's new parameters to force loop and links."""
    loop = user.loop
    if new.master is not old.master:
        loop.hand_over(partial(loop.configure, new.master))
    if new.safety is not old.safety:
        loop.hand_over(partial(loop.configure_safety, new.safety))
    if new.link_up is not old.link_up:
        user.up.configure(new.link_up)
    if new.link_down is not old.link_down:
        user.down.configure(new.link_down)
