# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy balances of each user's channel: what went in, less what came out.

    E_up   = sum_k |u_m|^2 T_c / 2 - sum_n |u_s|^2 T_VE / 2
    E_down = sum_n |v_s|^2 T_VE / 2 - sum_k |v_m|^2 T_c / 2
    E_hand = sum_k F_k (x_{k+1} - x_k) - sum_n (|u_s|^2 - |v_s|^2) T_VE / 2

at every server step. On the strict channel packets were paid with what went up, and what came
down is the playout's wave with what it released beside it. Without waves, and where something at
the device answers the outgoing wave at once, only E_hand exists. A block of a master counts once
it has ended, a server step with its whole period at its start (theory.md 13.1, 13.2, 13.3).

A recording leaves balances open in its holes, and between two clocks: a balance below the limit at
every alignment of two hosts' clocks within its uncertainty is a violation; one below at some is
not judged.
"""

from dataclasses import dataclass, field

import numpy as np

from pmwvc_analysis.budget.criterion import Balance, counts_j, together
from pmwvc_analysis.traces.block_sums import BlockSums, hand_work, up_to
from pmwvc_analysis.traces.holes import Kind, Unjudged, ran_s, stretch
from pmwvc_analysis.traces.sums import running, sum_of
from pmwvc_core.controllers.accounts import RELEASED, alters_wave
from pmwvc_core.controllers.library import record_of
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

STEPS = 9  # alignments that are tried within the uncertainty


@dataclass(frozen=True)
class UserEnergy:
    """The balances of one user; ``up`` and ``down`` are None where there are no waves."""

    name: str
    up: Balance | None
    down: Balance | None
    joint: Balance  # E_hand
    unjudged: list[Unjudged] = field(default_factory=list)

    @property
    def parts(self) -> dict[str, Balance]:
        """The balances that there are, by the name of the port that they judge."""
        parts = {"up": self.up, "down": self.down, "hand_port": self.joint}
        return {part: balance for part, balance in parts.items() if balance is not None}

    @property
    def passive(self) -> bool | None:
        """Tell whether every port is passive, whatever happened in gaps of the record."""
        ended = [each for each in self.unjudged if each.kind is not Kind.GAP]
        ports = (way.judged(self.name, part, ended) for part, way in self.parts.items())
        return together(port.passive for port in ports)


def user_energies(traces: SessionTraces, scenario: Scenario | None = None) -> list[UserEnergy]:
    """Return the balances of every user that both its own trace and the server's know. The
    scenario gives the declared storage and the step of the encoder; without it there is none.
    """
    if traces.server is None:
        return []
    there = [user for user in traces.users if user.name in traces.server.users]
    return [_of_user(user, traces.server, traces, scenario) for user in there]


def _of_user(
    user: UserTraces, server: ServerTraces, traces: SessionTraces, scenario: Scenario | None
) -> UserEnergy:
    known = next((u for u in scenario.users if u.name == user.name), None) if scenario else None
    judged, index = stretch(user, server), server.users.index(user.name)
    times, blocks = ran_s(server, traces), BlockSums(user, traces.live)
    rows = judged.known(times)
    times = times[rows]
    taken, given = (running(e[index])[rows] for e in (server.energy_u_s, server.energy_v_s))
    ended, sent = blocks.ended(times), blocks.sent(times)
    work, resolution = hand_work(user, known.device if known else None)
    passed_on = up_to(user.energy["v_m"] + user.accounts.get(RELEASED.name, 0.0), ended)
    up, down = None, None
    if scenario is not None and scenario.strict and known is not None:
        paid = up_to(user.energy["u_tx"], sent)
        up = Balance(times, paid, taken, float(scenario.server.store_j))
        if not alters_wave(known.master):
            down = Balance(times, given, passed_on, float(known.master.store_j))
    elif (user.u_m.any() or user.v_m.any()) and not user.accounts:
        up = Balance(times, up_to(user.energy["u_m"], ended), taken)
        down = Balance(times, given, passed_on)
    joint = Balance(
        times, up_to(work, ended), taken - given,
        declared_j(scenario, known) if scenario and known else 0.0,
        counts_j(traces, scenario, user.name), up_to(resolution, ended),
    )  # fmt: skip
    return UserEnergy(user.name, up, down, joint, judged.unjudged)


def server_sums(server: ServerTraces) -> tuple[Array, Array, Array]:
    """Return what the server took in at all ports, gave there, and holds or turned to heat."""
    u_s, v_s = (sum_of(map(running, e)) for e in (server.energy_u_s, server.energy_v_s))
    return u_s, v_s, server.kinetic + server.potential + server.dissipated


def declared_j(scenario: Scenario, user: User) -> float:
    """Return the energy that a user's ends hold at the start by their parameters [J]: of the
    controller, and on the strict channel of the playouts at both ends.
    """
    own_j = record_of(scenario.controller).storage_j(user.master, user.baseline)
    return own_j + scenario.strict * float(user.master.store_j + scenario.server.store_j)


def clocks_explain(part: str, balance: Balance, uncertain_s: float) -> str:
    """Return in words that a balance is passive at some alignment of the clocks of both ends,
    within its uncertainty [s]; empty: at none.
    """
    came, went, down = balance.energy_in_j, balance.energy_out_j, part == "down"
    for shift_s in np.linspace(-uncertain_s, uncertain_s, STEPS):  # of the master's clock
        times = balance.time_s - shift_s
        known = (times >= balance.time_s[0]) & (times <= balance.time_s[-1])
        moved = np.interp(times, balance.time_s, went if down else came)
        shifted = came - moved if down else moved - went
        if known.any() and (shifted >= balance.limit_j)[known].all():
            return f"the clocks of both ends are aligned within {uncertain_s * 1e3:.3g} ms"
    return ""
