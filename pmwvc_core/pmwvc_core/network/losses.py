# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Losses of a link that remember: by two states of Gilbert-Elliott, by four states, and around
hand-overs, as between satellites, at which the delay steps as well.

A model that is switched on again goes on where it was. What happens at the k-th hand-over is drawn
by k, whatever the packets do.
"""

from pmwvc_core.network.draws import Draws
from pmwvc_core.network.in_flight import Cause, Fate
from pmwvc_core.params import LinkParams

RECEIVED, WITHIN_BURST, IN_BURST, ISOLATED = 1, 2, 3, 4  # states; lost in the last two
STEP, OUTAGE, LENGTH, LOSS = range(4)  # numbers of a hand-over; the last is a packet's


class Losses:
    """The models of one link."""

    def __init__(self, draws: Draws) -> None:
        self._draws = draws
        self._bad = False
        self._state = RECEIVED

    def by_two_states(self, p: LinkParams, fate: Fate) -> bool:
        """Lose packets with one probability in the good state and with another in the bad one. The
        state changes after the packet; the link begins in the good one.
        """
        changes, loses = (self._draws.of("gilbert_elliott", fate, index) for index in (0, 1))
        lost = loses < (p.ge_bad if self._bad else p.ge_good)
        if changes < (p.ge_r if self._bad else p.ge_p):
            self._bad = not self._bad
        return lost

    def by_four_states(self, p: LinkParams, fate: Fate) -> bool:
        """Lose packets in bursts, within which some arrive, and singly."""
        u = self._draws.of("four_states", fate)
        if self._state == RECEIVED:
            if u < p.markov_p14:
                self._state = ISOLATED
            elif u < p.markov_p14 + p.markov_p13:
                self._state = IN_BURST
        elif self._state == WITHIN_BURST:
            self._state = IN_BURST if u < p.markov_p23 else WITHIN_BURST
        elif self._state == IN_BURST:
            if u < p.markov_p32:
                self._state = WITHIN_BURST
            elif u < p.markov_p32 + p.markov_p31:
                self._state = RECEIVED
        else:
            self._state = RECEIVED
        return self._state in (IN_BURST, ISOLATED)

    def by_hand_over(self, p: LinkParams, fate: Fate, elapsed_ns: int) -> Cause | bool:
        """Tell whether a packet meets an outage, or is lost around a hand-over."""
        draws, elapsed_s = self._draws, elapsed_ns * 1e-9
        count = int(elapsed_s / p.handover_s)
        since_s = elapsed_s - count * p.handover_s
        if count:
            happens, part = (draws.nth("handover", count, index) for index in (OUTAGE, LENGTH))
            low_s, high_s = p.handover_outage_min_s, p.handover_outage_max_s
            if happens < p.handover_outage and since_s < low_s + (high_s - low_s) * part:
                return Cause.OUTAGE
        near = (count > 0 and since_s < p.handover_loss_s) or (
            p.handover_s - since_s <= p.handover_loss_s
        )
        u = draws.of("handover", fate, LOSS)
        return near and u < p.handover_loss

    def step_s(self, p: LinkParams, elapsed_ns: int) -> float:
        """Return the step of the delay since the last hand-over [s]."""
        count = int(elapsed_ns * 1e-9 / p.handover_s)
        if not count:
            return 0.0
        return p.handover_step_s * (2.0 * self._draws.nth("handover", count, STEP) - 1.0)


def gilbert_loss(params: LinkParams) -> float:
    """Return the mean loss of the Gilbert-Elliott model."""
    p, r = params.ge_p, params.ge_r
    total = p + r
    return (params.ge_good * r + params.ge_bad * p) / total if total else params.ge_good


def markov_loss(params: LinkParams) -> float:
    """Return the mean loss of the four-state model, from the stationary probabilities."""
    p13, p31, p32 = params.markov_p13, params.markov_p31, params.markov_p32
    p23, p14 = params.markov_p23, params.markov_p14
    if p13 and not p31:
        return p23 / (p23 + p32) if p23 + p32 else 1.0  # a burst never ends
    in_burst = p13 / p31 if p13 else 0.0  # all relative to the state received
    if in_burst and p32 and not p23:
        return 0.0  # a burst ends in state 2 for good
    within = in_burst * p32 / p23 if p32 else 0.0
    return (in_burst + p14) / (1.0 + in_burst + within + p14)
