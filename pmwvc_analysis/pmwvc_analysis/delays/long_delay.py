# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops with long delays: opened at their links, so that packets under way are no states.

A delay of d ticks is q hyperperiods of N ticks and a rest. The rest stays inside the model;
for the q hyperperiods the link of a user is cut: what is sent in a hyperperiod arrives q
hyperperiods later.
Only the delay once around counts (a user's clock may be shifted against the server's), so each
user is cut once, in the direction with fewer packets. With H(Z) from the packets that come in to
those that are sent, Z the shift by a hyperperiod, the eigenvalues of the loop solve

    det(I - H(Z) diag(Z^-q)) = 0

with a few states in H, whatever the delay. :mod:`.windings` counts those outside a circle.
"""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.delays.ends import System, observable
from pmwvc_analysis.delays.windings import Loci
from pmwvc_analysis.models import rigid
from pmwvc_analysis.models.channel import delay_ticks
from pmwvc_analysis.models.loop import Loop, hyperframe_ticks
from pmwvc_core.numeric import Array
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario, User

LARGEST_DENSE = 80  # packets under way up to which all of them are states of one matrix
SHORT = 24  # packets under way up to which a link is left as it is beside longer ones
ROUNDING = 1e-9  # of ln(radius): beyond it is growth
DOUBLE = 1e-5  # the same where rigid motions are double eigenvalues, which rounding splits


class Opened(NamedTuple):
    """A loop that is open at its long links.

    Attributes
    ----------
    loci
        One per run.
    ticks
        N.
    at_one
        Per run, how many eigenvalues of the loop are 1 by a rigid motion that packets show.
    motions, states
        How many rigid motions the first run has, and how many states with all packets.
    """

    loci: list[Loci]
    ticks: int
    at_one: list[int]
    motions: int
    states: int

    def radii(self) -> Array:
        """Return the spectral radius over the hyperperiod of every run."""
        return np.exp([loci.log_radius() for loci in self.loci])

    def stable(self) -> NDArray[np.bool_]:
        """Tell of every run whether it is stable."""
        limits = [DOUBLE if ones > 1 else ROUNDING for ones in self.at_one]
        pairs = zip(self.loci, limits, strict=True)
        return np.array([loci.outside(limit) == 0 for loci, limit in pairs])


class _Cut:
    """A link that is cut: keeps what is sent and hands out what comes in instead."""

    def __init__(self, incoming: list[Array]) -> None:
        self.sent: list[Array] = []
        self._incoming = incoming

    def __call__(self, packet: list[Array]) -> list[Array]:
        place = len(self.sent)
        self.sent += packet
        return self._incoming[place : place + len(packet)]


def is_long(scenario: Scenario, *, live: bool = False) -> bool:
    """Tell whether more packets are under way than there should be states."""
    ticks, found = hyperframe_ticks(scenario), 0
    for user in scenario.users:
        whole, _, _ = _split(user, scenario, ticks, live=live)
        found += whole * (ticks // user.master.rate_drop + ticks // scenario.period_ticks)
    return found > LARGEST_DENSE


def opened(scenario: Scenario, *, live: bool = False, weights: Sequence[int] = ()) -> Opened:
    """Return the loop of a scenario whose numbers may be columns, opened at every link that is
    longer than a hyperperiod; see :class:`.loop.Loop`.
    """
    ticks = hyperframe_ticks(scenario)
    parts = [_split(user, scenario, ticks, live=live) for user in scenario.users]
    users = tuple(
        dataclasses.replace(user, link_up=up, link_down=down)
        for user, (_, up, down) in zip(scenario.users, parts, strict=True)
    )
    loop = Loop(dataclasses.replace(scenario, users=users), live=live, weights=weights)
    channels, delays = [], []
    for line, (whole, _, _) in zip(loop.lines, parts, strict=True):
        if whole:
            up = len(line.port.signals) * (ticks // line.frame.period)
            down = len(line.port.heard) * (ticks // loop.serve.period)
            channels.append((line.up, up) if up <= down else (line.down, down))
            delays += [whole] * min(up, down)
    states = len(loop.names)
    unit = loop.begin(states + len(delays))
    cuts, place = [], states
    for channel, count in channels:
        cuts.append(_Cut([unit[j : j + 1] for j in range(place, place + count)]))
        channel.relay = cuts[-1]
        place += count
    nothing = [np.zeros((1, place))] * len(loop.lines)
    for tick in range(ticks):
        loop.advance(tick, nothing)
    rows = _stacked([*loop.ended(), *(row for cut in cuts for row in cut.sent)])
    families = rigid.families(loop)
    found, at_one = [], []
    for run, whole_run in enumerate(rows):
        state, sent = whole_run[:states], whole_run[states:]
        system, ones = observable(
            System(state[:, :states], state[:, states:], sent[:, :states], sent[:, states:])
        )
        motions = sum(bool(np.broadcast_to(f.mask, len(rows))[run]) for f in families)
        at_one.append(max(motions - ones, 0))
        found.append(Loci(system, np.array(delays), at_one[-1]))
    return Opened(found, ticks, at_one, rigid.count(families), states + sum(delays))


def _stacked(rows: list[Array]) -> Array:
    """Return rows ``(1 or runs, width)`` as ``(runs, rows, width)``."""
    runs = max(len(row) for row in rows)
    width = rows[0].shape[-1]
    return np.stack([np.broadcast_to(row, (runs, width)) for row in rows], axis=1)


def _split(
    user: User, scenario: Scenario, ticks: int, *, live: bool
) -> tuple[int, LinkParams, LinkParams]:
    """Return whole hyperperiods of delay once around, and the links with what is left."""
    whole, left = 0, []
    for link in (user.link_up, user.link_down):
        delay = delay_ticks(link, tick_s=scenario.tick_s, live=live)
        q = max(delay - int(live), 0) // ticks
        left.append(LinkParams(delay_s=(delay - q * ticks) * scenario.tick_s))
        whole += q
    packets = whole * (ticks // user.master.rate_drop + ticks // scenario.period_ticks)
    if packets <= SHORT:
        return 0, user.link_up, user.link_down
    return whole, left[0], left[1]
