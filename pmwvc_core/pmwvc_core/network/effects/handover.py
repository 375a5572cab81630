# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Hand-overs, as between satellites: the delay steps, and there may be an outage and losses.

What happens at the k-th hand-over is drawn by k, whatever the packets do.
"""

from pmwvc_core.network.effects.record import Effect, LinkEffect, not_above
from pmwvc_core.network.in_flight import Cause, Fate
from pmwvc_core.params import LinkParams

STEP, OUTAGE, LENGTH, LOSS = range(4)  # indices of the random numbers; the last is a packet's


class Handover(Effect):
    """Change the delay at every hand-over, and lose packets around it."""

    def loses(self, fate: Fate) -> Cause | bool:
        """Tell whether a packet meets an outage, or is lost around a hand-over."""
        params, elapsed_s = self.params, (fate.time_in_ns - self.begin_ns) * 1e-9
        count = int(elapsed_s / params.handover_s)
        since_s = elapsed_s - count * params.handover_s
        if count and self.of_event(count, OUTAGE) < params.handover_outage:
            low_s, high_s = params.handover_outage_min_s, params.handover_outage_max_s
            if since_s < low_s + (high_s - low_s) * self.of_event(count, LENGTH):
                return Cause.OUTAGE
        to_next_s = params.handover_s - since_s
        near = (count > 0 and since_s < params.handover_loss_s) or (
            to_next_s <= params.handover_loss_s
        )
        return near and self.uniform(fate, LOSS) < params.handover_loss

    def delay_s(self, fate: Fate) -> float:
        """Return the step of the delay since the last hand-over [s]."""
        count = int((fate.time_in_ns - self.begin_ns) * 1e-9 / self.params.handover_s)
        if not count:
            return 0.0
        return self.params.handover_step_s * (2.0 * self.of_event(count, STEP) - 1.0)


def lost_ratio(params: LinkParams) -> float:
    """Return which part of the packets is lost on the mean."""
    outage_s = 0.5 * (params.handover_outage_min_s + params.handover_outage_max_s)
    around_s = min(2.0 * params.handover_loss_s, params.handover_s)
    lost_s = params.handover_outage * outage_s + params.handover_loss * around_s
    return min(lost_s / params.handover_s, 1.0)


RECORD = LinkEffect(
    name="handover",
    words="At hand-overs the delay steps and packets are lost.",
    linear="delay",
    make=Handover,
    active=lambda params: params.handover_s > 0.0,
    spreads=True,
    spread_s=lambda params: float(params.handover_step_s),
    amount=lambda params: (
        f"a hand-over every {params.handover_s:g} s (+-{params.handover_step_s * 1e3:g} ms; about "
        f"{lost_ratio(params):.2g} of the packets lost)"
    ),
    label=lambda params: f"hand-over every {float(params.handover_s):.4g} s",
    conflict=lambda params: not_above(params, "handover_outage_min_s", "handover_outage_max_s"),
)
