# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Where energy goes around a wave port with velocity filter, bank or position feedback [J].

Between u_m, v_m at the device and the outputs of filter and hold only the sum is seen in the
signals of the ticks:

    parts + filter + hold = (u_m^2 - v_m^2 - u_m_lp^2) T_c/2 summed + packets received

The parts book their own energies, at the end of each frame; the rest is filter and hold. So at the
ends of frames each is known exactly. In between the parts' are taken to go evenly.
"""

import numpy as np

from pmwvc_analysis.judge.budget_clock import AtFrames, Clock, Sums
from pmwvc_analysis.judge.budget_words import ACCOUNTS
from pmwvc_analysis.judge.energy import half_square
from pmwvc_core.simulation.scenario import User
from pmwvc_core.simulation.traces import UserTraces


def booked(accounts: Sums) -> Sums:
    """Return the accounts that are parts of a budget, as energy taken in."""
    known = {name: ACCOUNTS[name].taken for name in accounts if name in ACCOUNTS}
    return {name: sign * accounts[name] for name, sign in known.items() if sign}


def between(clock: Clock, user: UserTraces) -> Sums:
    """Return the booked parts at the instants of a budget."""
    ends = np.concatenate([[0.0], user.block_time_s])
    return {
        name: np.interp(clock.time_s, ends, np.concatenate([[0.0], sums]))
        for name, sums in booked(user.accounts).items()
    }


def at_frames(user: UserTraces, known: User) -> AtFrames:
    """Return booked parts, ``filter_and_hold`` and ``rate_drop`` at the ends of frames.

    The packet that a frame's filter output becomes is the next one sent.
    """
    parts, energy = booked(user.accounts), user.energy
    sent = np.concatenate([energy["u_tx"][1:], energy["u_tx"][-1:]])
    if known.master.filter.kind == "integrate_and_dump":
        filtered = sent
    else:
        count = np.searchsorted(user.time_s, user.block_time_s - 0.5 * user.tick_s)
        per_tick = half_square(user.u_m_lp) * user.tick_s
        filtered = np.concatenate([[0.0], np.cumsum(per_tick)])[count]
    inside = energy["u_m"] - energy["v_m"] - filtered + energy["v_rx"]
    rest = inside - np.sum(list(parts.values()), axis=0)
    found = {**parts, "filter_and_hold": rest, "rate_drop": filtered - sent}
    return AtFrames(user.block_time_s[:-1], {name: sums[:-1] for name, sums in found.items()})
