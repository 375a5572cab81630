# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Where energy goes around a wave port with velocity filter, bank or position feedback [J].

Between u_m, v_m at the device and the outputs of filter and hold only the sum is seen in the
signals of the ticks:

    parts + filter + hold = (u_m^2 - v_m^2 - u_m_lp^2) T_c/2 summed + packets received

The parts book their own energies, at the end of each frame; the rest is filter and hold. So at the
ends of frames each is known exactly. In between the parts' are taken to go evenly.

Equations: docs/theory.md 13.5.
"""

import numpy as np

from pmwvc_analysis.budget.budget_clock import AtFrames, Clock, Sums, sum_of
from pmwvc_analysis.budget.budget_words import booked
from pmwvc_analysis.traces.sums import half_square
from pmwvc_core.scenario.scenario import User
from pmwvc_core.traces import UserTraces

REST = ("filter_and_hold", "rate_drop")


def at_frames(user: UserTraces, known: User) -> AtFrames:
    """Return the parts, ``filter_and_hold`` and ``rate_drop`` at the ends of frames.

    The packet that a frame's filter output becomes is the next one sent, so the last frame is left
    out.
    """
    found = _at_frames(user, known)
    return AtFrames(user.block_time_s[:-1], {name: sums[:-1] for name, sums in found.items()})


def _at_frames(user: UserTraces, known: User) -> Sums:
    """Return all parts; see :func:`at_frames`.

    What a bank's low branch took in is what the anti-aliasing filter got, what it gave out came
    from the hold: so there filter and hold are known, and the bank is what is left.
    """
    parts, energy, accounts = booked(user.accounts), user.energy, user.accounts
    sent = np.concatenate([energy["u_tx"][1:], energy["u_tx"][-1:]])
    if known.master.filter.kind == "integrate_and_dump":
        filtered = sent
    else:
        count = np.searchsorted(user.time_s, user.block_time_s - 0.5 * user.tick_s)
        per_tick = half_square(user.u_m_lp) * user.tick_s
        filtered = np.concatenate([[0.0], np.cumsum(per_tick)])[count]
    left = energy["u_m"] - energy["v_m"] - filtered + energy["v_rx"]
    left = left - sum_of([0.0 * left, *parts.values()])
    found = {**parts, "filter_and_hold": left, "rate_drop": filtered - sent}
    if "bank_low_in" in accounts:
        net = accounts["bank_low_in"] - accounts["bank_low_out"]
        found["filter_and_hold"] = net - filtered + energy["v_rx"]
        if "position_spent" in parts:
            found["filter_and_hold"] = found["filter_and_hold"] - parts["position_spent"]
        found["bank"] = left - found["filter_and_hold"]
    return found


def between(clock: Clock, user: UserTraces, known: User) -> Sums:
    """Return the parts, without filter, hold and rate drop, at the instants of a budget."""
    found = _at_frames(user, known)
    return evenly(clock, user, {name: found[name] for name in found if name not in REST})


def evenly(clock: Clock, user: UserTraces, sums: Sums) -> Sums:
    """Return sums that are known at the ends of frames at the instants of a budget."""
    ends = np.concatenate([[0.0], user.block_time_s])
    return {
        name: np.interp(clock.time_s, ends, np.concatenate([[0.0], each]))
        for name, each in sums.items()
    }
