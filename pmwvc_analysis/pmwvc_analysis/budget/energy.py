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

A recording leaves balances open across its holes and between two clocks. *Holes:* running sums of
waves only grow, so E(t) >= in(start) - out(end) in a hole. Where that is above the limit, the
balance is judged across it. *Clocks:* a balance below the limit at every
alignment of two hosts' clocks within its uncertainty is a violation; one below at some is not
judged (theory.md 13.9).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pmwvc_analysis.budget.criterion import (
    Declared,
    Finding,
    counts_j,
    judge,
    together,
    tolerance,
)
from pmwvc_analysis.traces.block_sums import BlockSums, up_to
from pmwvc_analysis.traces.hand_work import hand_work
from pmwvc_analysis.traces.holes import AGAIN, Stretches, Unjudged, stretches
from pmwvc_analysis.traces.server_starts import completed, died_up, discarded, instants
from pmwvc_analysis.traces.sums import running, sum_of
from pmwvc_core.controllers.accounts import alters_wave
from pmwvc_core.controllers.library import record_of
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_core.words import quantity

UNRESOLVED = "the steps of the encoder leave the work of the hand open"
STEPS = 9  # alignments that are tried within the uncertainty


@dataclass(frozen=True)
class Balance:
    """One balance over time, and what the criterion of passivity allows it beside rounding."""

    time_s: Array  # (step,)
    energy_in_j: Array
    energy_out_j: Array
    declared_j: float = 0.0  # stored at the start
    counts_j: float = 0.0  # that counts of an encoder are bounded to make of it
    resolution_j: Array | float = 0.0  # (step,) how far it may be off, as an encoder has steps

    @property
    def balance_j(self) -> Array:
        """Energy in less energy out [J]."""
        return self.energy_in_j - self.energy_out_j

    @property
    def tolerance_j(self) -> Array:
        """Largest deficit that counts as zero [J]."""
        return tolerance(self.energy_in_j)

    @property
    def limit_j(self) -> Array:
        """The lowest balance that is passive, without what the encoder leaves open [J]."""
        return -self.tolerance_j - self.declared_j - self.counts_j

    @property
    def minimum_j(self) -> float:
        """The lowest balance, never above the zero it starts from [J]."""
        return min(0.0, float(self.balance_j.min(initial=0.0)))

    def judged(self, owner: str, part: str, unjudged: Sequence[Unjudged] = ()) -> Finding:
        """Return the result of the criterion; not judged where the encoder cannot resolve it."""
        moved = np.abs([self.energy_in_j, self.energy_out_j])
        found = judge(
            owner, part, self.time_s, self.balance_j, decides=True, unjudged=unjudged,
            moved_j=float(moved.max(initial=0.0)), declared_j=self.declared_j,
            counts_j=self.counts_j, tolerance_j=self.tolerance_j + self.resolution_j,
        )  # fmt: skip
        least_j = self.balance_j - self.resolution_j
        if found.passive and np.any(self.resolution_j) and (least_j < self.limit_j).any():
            most_mj = 1e3 * float(np.max(self.resolution_j))
            why = f"{UNRESOLVED} by up to {most_mj:.3g} mJ"
            return replace(found, passive=None, why=why)
        return found


@dataclass(frozen=True)
class UserEnergy:
    """The balances of one user; ``up`` and ``down`` are None where there are no waves."""

    name: str
    up: Balance | None
    down: Balance | None
    joint: Balance  # E_hand
    stretches: Stretches = field(default_factory=lambda: Stretches([], []))

    @property
    def parts(self) -> dict[str, Balance]:
        """The balances that there are, by the name of the port that they judge."""
        parts = {"up": self.up, "down": self.down, "hand_port": self.joint}
        return {part: balance for part, balance in parts.items() if balance is not None}

    @property
    def passive(self) -> bool | None:
        """Tell whether every port is passive, whatever was not recorded."""
        return together(way.judged(self.name, part).passive for part, way in self.parts.items())


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
    index = server.users.index(user.name)
    times, steps = instants(server, traces)
    stays = stretches(user, server, traces)
    rows = stays.known(times)
    taken = running(server.energy_u_s[index])
    v_s = running(server.energy_v_s[index])[steps]
    v_s = completed(v_s, times, server, traces, user.name)
    died = died_up(times, server, traces, user.name, taken)

    def begun(sums: Array, since: str = "begun_s") -> Array:
        """Return running sums that begin at zero with every life but the first."""
        result = sums.copy()
        for life in stays.lives[1:]:
            base = max(int(np.searchsorted(times, getattr(life, since))) - 1, 0)
            of_life = (times >= life.start_s) & (times <= life.end_s)
            result[of_life] = sums[of_life] - sums[base]
        return result[rows]

    taken = begun(taken[steps], "joined_s")
    blocks = BlockSums(user, traces.live)
    ended, sent = blocks.ended(times), blocks.sent(times)
    work = hand_work(user, known.device if known else None)
    passed_on = begun(up_to(blocks.of_wave("v_m") + blocks.released, ended))
    gone, up, down = died, None, None
    if scenario is not None and scenario.strict and known is not None:
        paid_j = begun(up_to(user.energy["u_tx"], sent) - died)
        up = Balance(times[rows], paid_j, taken, float(scenario.server.store_j))
        given_up = discarded(times, server, traces, blocks)
        gone = died + given_up
        if not alters_wave(known.master):
            lent_j = float(known.master.store_j)
            down = Balance(times[rows], begun(v_s - given_up), passed_on, lent_j)
    elif (user.u_m.any() or user.v_m.any()) and not user.accounts:
        up = Balance(times[rows], begun(up_to(blocks.of_wave("u_m"), ended) - died), taken)
        down = Balance(times[rows], begun(v_s), passed_on)
    else:
        gone = np.zeros(len(times))
    declared_j = sum(declared(scenario, known)) if scenario and known else 0.0
    bound_j = counts_j(traces, scenario, user.name)
    came, went = begun(up_to(work.sums, ended) - gone), taken - begun(v_s)
    open_j = up_to(work.resolution, ended)[rows]
    joint = Balance(times[rows], came, went, declared_j, bound_j, open_j)
    return UserEnergy(user.name, up, down, joint, stays)


def server_sums(server: ServerTraces) -> tuple[Array, Array, Array]:
    """Return what the server took in at all ports, gave there, and holds or turned to heat."""
    u_s, v_s = (sum_of(map(running, e)) for e in (server.energy_u_s, server.energy_v_s))
    return u_s, v_s, server.kinetic + server.potential + server.dissipated


def declared(scenario: Scenario, user: User) -> Declared:
    """Return the energy that a user's ends hold at the start."""
    own = record_of(scenario.controller).storage_j(user.master, user.baseline)
    return Declared(own, scenario.strict * float(user.master.store_j + scenario.server.store_j))


def hidden(balance: Balance, unknown: Sequence[Unjudged]) -> list[Unjudged]:
    """Return the intervals that may hide a violation of a balance whose sums never fall."""
    found = []
    for interval in unknown:
        before = int(np.searchsorted(balance.time_s, interval.start_s, side="right")) - 1
        after = int(np.searchsorted(balance.time_s, interval.end_s))
        if interval.why != AGAIN and after < len(balance.time_s):
            came = float(balance.energy_in_j[before]) if before >= 0 else 0.0
            least = came - float(balance.energy_out_j[after])
            if least >= -float(balance.tolerance_j[after]):
                continue
        found.append(interval)
    return found


def within(found: Finding, entry: UserEnergy, uncertain_s: float) -> Finding:
    """Return a finding as it is with the uncertainty of the alignment [s]."""
    balance = entry.parts[found.part]
    if found.passive is not False or uncertain_s <= 0.0:
        return found
    came, went, down = balance.energy_in_j, balance.energy_out_j, found.part == "down"
    for shift_s in np.linspace(-uncertain_s, uncertain_s, STEPS):  # of the master's clock
        times = balance.time_s - shift_s
        known = (times >= balance.time_s[0]) & (times <= balance.time_s[-1])
        moved = np.interp(times, balance.time_s, went if down else came)
        shifted = came - moved if down else moved - went
        if known.any() and (shifted >= balance.limit_j)[known].all():
            why = (
                f"the clocks of both ends are aligned within {uncertain_s * 1e3:.3g} ms, which "
                f"explains the least balance of {quantity(found.least_j, 'J')}"
            )
            return replace(found, passive=None, why=why)
    return found
