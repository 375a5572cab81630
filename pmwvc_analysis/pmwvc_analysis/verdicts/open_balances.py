# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The balances that a recording leaves open: across its holes, and between two clocks.

*Holes.* Running sums of waves only grow: in a hole E(t) >= in(start) - out(end). Where that is
above the limit, the balance is judged across it. Where only the server's records are missing,
E_hand(t) >= work(t) - u_s(end) + v_s(start), with the work tick by tick.

*Clocks.* A balance below the limit at every alignment of two hosts' clocks within its uncertainty
is a violation; one below at some is not judged (theory.md 13.9).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pmwvc_analysis.budget.criterion import Finding
from pmwvc_analysis.budget.energy import Balance, UserEnergy
from pmwvc_analysis.traces.holes import Unjudged
from pmwvc_analysis.traces.stretches import AGAIN
from pmwvc_core.quantities import quantity

ROUNDING_S = 1e-6  # of times
STEPS = 9  # alignments that are tried within the uncertainty


def hidden(balance: Balance, unknown: Sequence[Unjudged]) -> list[Unjudged]:
    """Return the intervals that may hide a violation of a balance whose sums never fall."""
    found = []
    for interval in unknown:
        before, after = _around(interval, balance)
        if interval.why != AGAIN and after < len(balance.time_s):
            came = float(balance.energy_in_j[before]) if before >= 0 else 0.0
            least = came - float(balance.energy_out_j[after])
            if least >= -float(balance.tolerance_j[after]):
                continue
        found.append(interval)
    return found


def _around(interval: Unjudged, balance: Balance) -> tuple[int, int]:
    """Return the rows of a balance before an interval, -1: none, and behind it."""
    before = int(np.searchsorted(balance.time_s, interval.start_s, side="right")) - 1
    return before, int(np.searchsorted(balance.time_s, interval.end_s))


def bounded(entry: UserEnergy, unknown: Sequence[Unjudged]) -> dict[Unjudged, float]:
    """Return, of holes in the server's records, those in which the balance at the port of the hand
    is bounded to be above its limit, and the least that it can have been [J].
    """
    joint, hand, given_j = entry.joint, entry.hand, entry.given_j
    taken_j = joint.energy_out_j + given_j
    found: dict[Unjudged, float] = {}
    for interval in unknown:
        before, after = _around(interval, joint)
        if hand is None or before < 0 or after >= len(joint.time_s):
            continue
        first, last = np.searchsorted(hand.ran_s, joint.time_s[[before, after]] - ROUNDING_S)
        sums = np.concatenate([[0.0], hand.sums])[first : last + 1]
        worked_j = float(sums.min() - sums[0])
        # what was given up or begun anew in between counts from the beginning on
        gone_j = float(joint.energy_in_j[before] + sums[-1] - sums[0] - joint.energy_in_j[after])
        came_j = float(joint.energy_in_j[before]) + worked_j - max(gone_j, 0.0)
        least_j = came_j - float(taken_j[after] - given_j[before])
        open_j = float(joint.tolerance_j[after] + entry.storage_j + entry.counts_j)
        if least_j - float(entry.resolution_j[after]) >= -open_j:
            found[interval] = least_j
    return found


def within(found: Finding, entry: UserEnergy, uncertain_s: float) -> Finding:
    """Return a finding as it is with the uncertainty of the alignment [s]."""
    balance = {"up": entry.up, "down": entry.down, "hand_port": entry.joint}[found.part]
    if found.passive is not False or uncertain_s <= 0.0 or balance is None:
        return found
    limit = balance.tolerance_j + found.declared_j + found.counts_j
    came, went, down = balance.energy_in_j, balance.energy_out_j, found.part == "down"
    for shift_s in np.linspace(-uncertain_s, uncertain_s, STEPS):  # of the master's clock
        times = balance.time_s - shift_s
        known = (times >= balance.time_s[0]) & (times <= balance.time_s[-1])
        moved = np.interp(times, balance.time_s, went if down else came)
        shifted = came - moved if down else moved - went
        if known.any() and (shifted >= -limit)[known].all():
            why = (
                f"the clocks of both ends are aligned within {uncertain_s * 1e3:.3g} ms, which "
                f"explains the least balance of {quantity(found.least_j, 'J')}"
            )
            return replace(found, passive=None, why=why)
    return found
