# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parts of the channel at the ends of the master's frames, and between them."""

from typing import NamedTuple

import numpy as np
from oracle.offline_budget.sums import Clock, Sums, evenly, half_square, sum_of

from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import User
from pmwvc_core.traces import UserTraces

KEPT = ("velocity_filter", "local_stored", "local_dissipated", "tdpa_dissipated")

SPENT = ("position_spent",)

REST = ("filter_and_hold", "rate_drop")


class AtFrames(NamedTuple):
    """Running sums at times of their own: the ends of a master's frames."""

    time_s: Array
    sums: Sums


def booked(accounts: dict[str, Array]) -> Sums:
    """Return the accounts that are parts of a budget, as energy taken in."""
    kept = {name: accounts[name] for name in accounts if name in KEPT}
    return kept | {name: -accounts[name] for name in accounts if name in SPENT}


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
