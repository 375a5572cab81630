# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy that went into each direction of each user's channel, less what came out.

Up, at the time of each server step: what the waves of the master brought, less what the server
made of them,

    E_up = sum_k |u_m|^2 T_c / 2 - sum_n |u_s|^2 T_VE / 2,

down, likewise, E_down = sum_n |v_s|^2 T_VE / 2 - sum_k |v_m|^2 T_c / 2. A channel that holds or
wastes energy has a balance >= 0 at every instant; one below zero has given out energy that it
never got.

What counts when: a tick counts once it has run, a server step counts with its whole period at
its start. A server step answers packets sent before it, and a master expands values sent before,
so cause is never behind effect. A late server step is taken at the time it really ran. Where the
trace of a master ends, or goes on with another life of it, its last ticks may be missing that the
server still got: the balance ends there.

Without waves the two directions cannot be told apart; there, only the joint balance
of the two ports exists, sum_k F_m xd_m T_c - sum_n F_s xd_s T_VE, which for waves is E_up +
E_down. Nor can they where something at the device answers the outgoing wave at once (velocity
filter, filter bank): what goes up and what comes down is then partly the same wave. There the
joint balance is sum_k F_m xd_m T_c - sum_n (|u_s|^2 - |v_s|^2) T_VE/2.
"""

from dataclasses import dataclass

import numpy as np

from pmwvc_analysis.judge.passivity import tolerance
from pmwvc_core.numeric import Array
from pmwvc_core.simulation.traces import ServerTraces, SessionTraces, UserTraces


@dataclass(frozen=True)
class Balance:
    """One balance over time, and how far below zero rounding may take it."""

    time_s: Array  # (step,)
    energy_in_j: Array
    energy_out_j: Array

    @property
    def balance_j(self) -> Array:
        """Energy in less energy out [J]."""
        return self.energy_in_j - self.energy_out_j

    @property
    def tolerance_j(self) -> Array:
        """What counts as zero (passivity.py) [J]."""
        return tolerance(self.energy_in_j)

    @property
    def violated(self) -> np.typing.NDArray[np.bool_]:
        """Where more came out than had gone in."""
        return self.balance_j < -self.tolerance_j

    @property
    def passive(self) -> bool:
        """Tell whether the balance never was below zero."""
        return not bool(self.violated.any())

    @property
    def minimum_j(self) -> float:
        """The lowest balance, never above the zero it starts from [J]."""
        return min(0.0, float(self.balance_j.min(initial=0.0)))

    @property
    def minimum_time_s(self) -> float | None:
        """When the balance was lowest, or None when it never went below zero [s]."""
        return float(self.time_s[int(np.argmin(self.balance_j))]) if self.minimum_j < 0.0 else None


@dataclass(frozen=True)
class UserEnergy:
    """The balances of one user; ``up`` and ``down`` are None where there are no waves."""

    name: str
    up: Balance | None
    down: Balance | None
    joint: Balance

    @property
    def passive(self) -> bool:
        """Tell whether no balance was ever below zero."""
        parts = [part for part in (self.up, self.down) if part is not None] or [self.joint]
        return all(part.passive for part in parts)


def user_energies(traces: SessionTraces) -> list[UserEnergy]:
    """Return the balances of every user that both its own trace and the server's know."""
    if traces.server is None:
        return []
    known = set(traces.server.users)
    lateness = traces.metadata.get("server_lateness_s")
    return [_of_user(user, traces.server, lateness) for user in traces.users if user.name in known]


def _of_user(user: UserTraces, server: ServerTraces, lateness: Array | None) -> UserEnergy:
    place = server.users.index(user.name)
    times = server.time_s
    if lateness is not None and len(lateness) == len(times):
        times = times + lateness
    known = times <= _end_s(user)
    if user.tick[0] > 0:  # the recorder found this master only when it was running
        known &= times >= user.time_s[0] + user.tick_s
    times = times[known]
    power_in = np.sum(user.f_applied * user.xd_m, axis=-1)
    power_out = np.nan_to_num(np.sum(server.f_s[place] * server.xd_s[place], axis=-1))
    work = anchored(user, power_in * user.tick_s, user.energy.get("device"))
    u_s, v_s = running(server.energy_u_s[place]), running(server.energy_v_s[place])
    waves = bool(user.u_m.any() or user.v_m.any())
    if user.accounts or not waves:
        joint = Balance(times, _at(times, user, work), (u_s - v_s)[known])
        return UserEnergy(user.name, None, None, joint)
    out = (np.cumsum(power_out) * server.period_s)[known]
    joint = Balance(times, _at(times, user, work), out)
    u_m = anchored(user, half_square(user.u_m) * user.tick_s, user.energy.get("u_m"))
    v_m = anchored(user, half_square(user.v_m) * user.tick_s, user.energy.get("v_m"))
    up = Balance(times, _at(times, user, u_m), u_s[known])
    down = Balance(times, v_s[known], _at(times, user, v_m))
    return UserEnergy(user.name, up, down, joint)


def _end_s(user: UserTraces) -> float:
    """Return when the first life of a master that is on record ends [s]."""
    again = np.flatnonzero(np.diff(user.tick) < 0)
    last = int(again[0]) if len(again) else -1
    return float(user.time_s[last] + user.lateness_s[last] + 1.5 * user.tick_s)


def half_square(wave: Array) -> Array:
    """Return the power of a wave, |w|^2 / 2 [W], per row."""
    power: Array = np.sum(wave * wave, axis=-1) / 2.0
    return power


def running(sums: Array) -> Array:
    """Return sums that only grow, going on where a user that left and came back began at zero."""
    result = sums.copy()
    for row in np.flatnonzero(np.diff(sums) < 0.0) + 1:
        result[row:] += result[row - 1] - (result[row] - sums[row])
    return result


def anchored(user: UserTraces, per_tick: Array, at_block_ends: Array | None) -> Array:
    """Return the running sum after each tick [J].

    The sums that the master itself kept, at the ends of its blocks, hold; in between the ticks'
    own values are added. So a block that was not recorded leaves no hole in the energy.
    """
    sums: Array = np.cumsum(per_tick)
    if at_block_ends is None or not len(at_block_ends):
        return sums
    last = np.searchsorted(user.time_s, user.block_time_s - 0.5 * user.tick_s) - 1
    blocks = np.clip(np.searchsorted(last, np.arange(len(sums))), 0, len(last) - 1)
    ends = np.clip(last, 0, len(sums) - 1)
    return sums + (at_block_ends - sums[ends])[blocks]


def _at(times: Array, user: UserTraces, sums: Array) -> Array:
    """Return a sum per tick at other times: of all ticks that ran before (times are rounded)."""
    ran = np.maximum.accumulate(user.time_s + user.lateness_s)
    count = np.searchsorted(ran, times - 0.001 * user.tick_s)
    return np.concatenate([[0.0], sums])[count]
