# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy balances of each user's channel: what went in, less what came out.

    E_up   = sum_k |u_m|^2 T_c / 2 - sum_n |u_s|^2 T_VE / 2
    E_down = sum_n |v_s|^2 T_VE / 2 - sum_k |v_m|^2 T_c / 2
    E_hand = sum_k F_k (x_{k+1} - x_k) - sum_n (|u_s|^2 - |v_s|^2) T_VE / 2

at every server step. On the strict channel packets were paid with what went up, and what came
down is the playout's wave with what it released beside it. Without waves, and where something at
the device answers the outgoing wave at once, only E_hand exists. A tick counts once it has run, a
server step with its whole period at its start (theory.md 13.1, 13.2, 13.3).
"""

from dataclasses import dataclass, field

import numpy as np

from pmwvc_analysis.budget.blocks import paid, released
from pmwvc_analysis.budget.criterion import Declared, counts_j, tolerance
from pmwvc_analysis.traces.hand_work import Work, hand_work
from pmwvc_analysis.traces.server_starts import completed, died_up, discarded, instants
from pmwvc_analysis.traces.stretches import Stretches, stretches
from pmwvc_analysis.traces.sums import UserSums, running
from pmwvc_core.controllers.accounts import alters_wave
from pmwvc_core.controllers.library import record_of
from pmwvc_core.numeric import Array, Flags
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces


@dataclass(frozen=True)
class Balance:
    """One balance over time, and the energy declared to be stored at the start."""

    time_s: Array  # (step,)
    energy_in_j: Array
    energy_out_j: Array
    storage_j: float = 0.0

    @property
    def balance_j(self) -> Array:
        """Energy in less energy out [J]."""
        return self.energy_in_j - self.energy_out_j

    @property
    def tolerance_j(self) -> Array:
        """Largest deficit that counts as zero [J]."""
        return tolerance(self.energy_in_j)

    @property
    def violated(self) -> Flags:
        """Flags where more came out than went in before and was declared to be stored."""
        return self.balance_j < -self.tolerance_j - self.storage_j

    @property
    def minimum_j(self) -> float:
        """The lowest balance, never above the zero it starts from [J]."""
        return min(0.0, float(self.balance_j.min(initial=0.0)))

    @property
    def minimum_time_s(self) -> float | None:
        """Time of the lowest balance [s]; None: it never was below zero."""
        return float(self.time_s[int(np.argmin(self.balance_j))]) if self.minimum_j < 0.0 else None


@dataclass(frozen=True)
class UserEnergy:
    """The balances of one user; ``up`` and ``down`` are None where there are no waves."""

    name: str
    up: Balance | None
    down: Balance | None
    joint: Balance  # E_hand
    resolution_j: Array  # how far that may be off, because an encoder has steps
    storage_j: float = 0.0  # that the controller was declared to hold at the start
    stretches: Stretches = field(default_factory=lambda: Stretches([], []))
    counts_j: float = 0.0  # that counts of an encoder are bounded to make of the hand's work
    given_j: Array = field(default_factory=lambda: np.zeros(0))  # of v_s, at the times of joint
    hand: Work | None = None  # the hand's work tick by tick; None where it is known by blocks only

    @property
    def hand_passive(self) -> bool | None:
        """Tell whether E_hand is passive; None where the encoder cannot resolve it."""
        limit = -self.joint.tolerance_j - self.storage_j - self.counts_j
        if (self.joint.balance_j + self.resolution_j < limit).any():
            return False
        return None if (self.joint.balance_j - self.resolution_j < limit).any() else True

    @property
    def passive(self) -> bool | None:
        """Tell whether every balance was above zero, and E_hand above minus the storage and the
        bound; None that the encoder cannot resolve.
        """
        violated = any(way is not None and way.violated.any() for way in (self.up, self.down))
        return False if violated else self.hand_passive


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
    work = hand_work(user, known.device if known else None)
    (worked, resolution), gone = work.at(user, times), np.zeros(len(times))
    sums, up, down = UserSums(user, times, to_end=True), None, None
    if scenario is not None and scenario.strict and known is not None:
        paid_j = begun(paid(sums, live=traces.live) - died)
        up = Balance(times[rows], paid_j, taken, float(scenario.server.store_j))
        given_up = discarded(times, server, traces, sums)
        gone = died + given_up
        if not alters_wave(known.master):
            given = sums.of_wave("v_m") + released(sums, after_s=np.inf)
            lent_j = float(known.master.store_j)
            down = Balance(times[rows], begun(v_s - given_up), begun(given), lent_j)
    elif (user.u_m.any() or user.v_m.any()) and not user.accounts:
        up = Balance(times[rows], begun(sums.of_wave("u_m") - died), taken)
        down = Balance(times[rows], begun(v_s), begun(sums.of_wave("v_m")))
        gone = died
    given_j = begun(v_s)
    joint = Balance(times[rows], begun(worked - gone), taken - given_j)
    return UserEnergy(
        user.name, up, down, joint, resolution[rows],
        storage_j=sum(declared(scenario, known)) if scenario and known else 0.0,
        stretches=stays, counts_j=counts_j(traces, scenario, user.name), given_j=given_j,
        hand=work if len(work.sums) == len(user.time_s) else None,
    )  # fmt: skip


def declared(scenario: Scenario, user: User) -> Declared:
    """Return the energy that a user's ends hold at the start."""
    own = record_of(scenario.controller).storage_j(user.master, user.baseline)
    return Declared(own, scenario.strict * float(user.master.store_j + scenario.server.store_j))
