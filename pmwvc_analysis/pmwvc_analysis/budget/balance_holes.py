# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a hole of the recording leaves unknown of an energy balance.

Master and server keep running sums, so both ends of a hole are known. Within it the sums of waves
only grow: at most what had come out at its end can have met what had gone in at its start,

    E(t) >= in(start) - out(end)      for every t in the hole.

Where that is above the limit, the hole hides nothing and the balance is judged across it. The work
of the hand may go either way: there a hole is not judged.
"""

from collections.abc import Sequence

import numpy as np

from pmwvc_analysis.budget.energy import Balance
from pmwvc_analysis.budget.stretches import AGAIN
from pmwvc_analysis.verdicts.passivity import Unjudged


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
