# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets lost (each by itself, by two states of Gilbert-Elliott, or by four), copied, corrupted
or sent at once, all by chance.
"""

from pmwvc_core.network.effects.record import Effect, linux_effect, made_of
from pmwvc_core.network.in_flight import Fate
from pmwvc_core.params import LinkParams

RECEIVED, WITHIN_BURST, IN_BURST, ISOLATED = 1, 2, 3, 4  # states; lost in the last two


def loses(effect: Effect, fate: Fate) -> bool:
    """Lose packets with one probability."""
    return effect.correlated(fate, effect.params.loss_correlation) < effect.params.loss


class GilbertElliott(Effect):
    """Lose packets with one probability in the good state and with another in the bad one. The
    state changes after the packet; the link begins in the good one.
    """

    bad = False

    def loses(self, fate: Fate) -> bool:
        """Tell whether a packet is lost."""
        p = self.params
        lost = self.uniform(fate, 1) < (p.ge_bad if self.bad else p.ge_good)
        if self.uniform(fate) < (p.ge_r if self.bad else p.ge_p):
            self.bad = not self.bad
        return lost


class FourStates(Effect):
    """Lose packets in two of four states: in bursts, within which some arrive, and singly."""

    state = RECEIVED

    def loses(self, fate: Fate) -> bool:
        """Tell whether a packet is lost: one that meets state 3 or 4."""
        p, u = self.params, self.uniform(fate)
        if self.state == RECEIVED:
            if u < p.markov_p14:
                self.state = ISOLATED
            elif u < p.markov_p14 + p.markov_p13:
                self.state = IN_BURST
        elif self.state == WITHIN_BURST:
            self.state = IN_BURST if u < p.markov_p23 else WITHIN_BURST
        elif self.state == IN_BURST:
            if u < p.markov_p32:
                self.state = WITHIN_BURST
            elif u < p.markov_p32 + p.markov_p31:
                self.state = RECEIVED
        else:
            self.state = RECEIVED
        return self.state in (IN_BURST, ISOLATED)


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


def _markov_conflict(params: LinkParams) -> str:
    for first, second in (("markov_p13", "markov_p14"), ("markov_p31", "markov_p32")):
        total = getattr(params, first) + getattr(params, second)
        if total > 1.0 + 1e-12:
            return f"{first} + {second} = {total:g}: must be 0..1"
    return ""


def copies(effect: Effect, fate: Fate) -> int:
    """Copy packets with one probability."""
    p = effect.params
    return int(effect.correlated(fate, p.duplicate_correlation) < p.duplicate)


def corrupts(effect: Effect, fate: Fate) -> float | None:
    """Corrupt packets and copies with one probability: one bit is flipped."""
    p = effect.params
    flips = effect.correlated(fate, p.corrupt_correlation) < p.corrupt
    return effect.uniform(fate, 1) if flips else None


class Reordering(Effect):
    """Send at once, with one probability, one packet after every ``reorder_gap - 1`` others."""

    _since = 0  # packets since the last one sent at once

    def at_once(self, fate: Fate) -> bool:
        """Tell whether a packet or copy goes without delay."""
        p = self.params
        u = self.correlated(fate, p.reorder_correlation)
        at_once = self._since >= p.reorder_gap - 1 and u < p.reorder
        self._since = 0 if at_once else self._since + 1
        return at_once


LOSS = linux_effect(
    name="loss",
    words="Packets are lost, each with the same probability.",
    make=made_of(loses=loses),
    active=lambda params: params.loss > 0.0,
    slot=0,
    amount=lambda params: f"loss of {params.loss:.3g} of the packets",
    label=lambda params: f"loss {float(params.loss * 100.0):.4g} %",
)
GILBERT = linux_effect(
    name="gilbert_elliott",
    words="Packets are lost in bursts, by two states.",
    make=GilbertElliott,
    active=lambda params: params.ge_p > 0.0 or params.ge_good > 0.0,
    amount=lambda params: f"loss of {gilbert_loss(params):.3g} of the packets, in bursts",
    label=lambda params: f"bursts of loss {gilbert_loss(params) * 100.0:.4g} %",
)
MARKOV = linux_effect(
    name="four_states",
    words="Packets are lost in bursts and singly, by four states.",
    make=FourStates,
    active=lambda params: params.markov_p13 > 0.0 or params.markov_p14 > 0.0,
    amount=lambda params: f"loss of {markov_loss(params):.3g} of the packets, by four states",
    label=lambda params: f"loss {markov_loss(params) * 100.0:.4g} % (four states)",
    conflict=_markov_conflict,
)
DUPLICATION = linux_effect(
    name="duplication",
    words="Packets arrive twice, each with the same probability.",
    make=made_of(copies=copies),
    active=lambda params: params.duplicate > 0.0,
    slot=1,
    amount=lambda params: f"duplication of {params.duplicate:.3g} of the packets",
)
CORRUPTION = linux_effect(
    name="corruption",
    words="One bit of a packet is flipped, with the same probability in each.",
    make=made_of(corrupts=corrupts),
    active=lambda params: params.corrupt > 0.0,
    amount=lambda params: f"corruption of {params.corrupt:.3g} of the packets",
    label=lambda params: f"corrupt {float(params.corrupt * 100.0):.4g} %",
)
REORDERING = linux_effect(
    name="reordering",
    words="Some packets are sent at once and overtake others.",
    make=Reordering,
    active=lambda params: params.reorder > 0.0,
    spreads=True,
    amount=lambda params: f"reordering of {params.reorder:.3g} of the packets",
    label=lambda params: f"reorder {float(params.reorder * 100.0):.4g} %",
    conflict=lambda params: (
        f"reorder = {params.reorder:g}: nothing is reordered unless keep_order is false"
        if params.keep_order
        else ""
    ),
)
