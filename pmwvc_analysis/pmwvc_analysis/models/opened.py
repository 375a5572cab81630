# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops opened at their links: what is sent there of what comes in, as a small linear system.

**Long delays.** A delay of d ticks is q hyperperiods of N ticks and a rest. The rest stays inside
the model; for the q hyperperiods the link of a user is cut. Only the delay once around counts (a
user's clock may be shifted against the server's), so each user is cut once, in the direction with
fewer packets. With H(Z) from the packets that come in to those that are sent, Z the shift by a
hyperperiod, the eigenvalues of the loop solve

    det(I - H(Z) diag(Z^-q)) = 0

with a few states in H, whatever the delay. :mod:`.windings` counts those outside a circle.

**Ends.** Cut in both directions with frames as long as steps, the master's end (hold, device,
controller, filter and rate drop, with their aliasing) takes one packet v a frame and sends one
packet u; the server's takes a packet u of every user and answers with v.

States that are not read (where a device or the object is) are left out: they do not go round.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.models.elements import Path
from pmwvc_analysis.models.linearize import Linear, model_of
from pmwvc_analysis.models.links import delay_ticks, hyperperiod_ticks
from pmwvc_analysis.models.outside import checked
from pmwvc_analysis.models.variation import with_links
from pmwvc_analysis.models.windings import Loci, System
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.numeric import Array, Flags, Integers
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.scenario import Scenario, User

LARGEST_DENSE = 80  # packets under way up to which all of them are states of one matrix
SHORT = 24  # packets under way up to which a link is left as it is beside longer ones
ROUNDING = 1e-9  # of ln(radius): beyond it is growth
DOUBLE = 1e-5  # the same where rigid motions are double eigenvalues, which rounding splits


class Opened(NamedTuple):
    """A loop that is open at its long links."""

    loci: list[Loci]  # one per run
    ticks: int  # N
    motions: int  # rigid ones of the first run
    states: int  # with all packets

    @property
    def limits(self) -> list[float]:
        """ln(radius) of every run beyond which it grows."""
        return [DOUBLE if loci.at_one > 1 else ROUNDING for loci in self.loci]

    def radii(self) -> Array:
        """Return every run's spectral radius over the hyperperiod, 1 where rounding hides more."""
        found = np.array([loci.log_radius() for loci in self.loci])
        return np.exp(np.where((found > 0.0) & (found <= self.limits), 0.0, found))

    def stable(self) -> Flags:
        """Tell of every run whether it is stable."""
        pairs = zip(self.loci, self.limits, strict=True)
        return np.array([loci.outside(limit) == 0 for loci, limit in pairs])


def is_long(scenario: Scenario, *, live: bool = False) -> bool:
    """Tell whether more packets are under way than there should be states, more where several
    signals of a hyperperiod go round: loci take longer than eigenvalues.
    """
    ticks, found, signals = hyperperiod_ticks(scenario), 0, 1
    for user in scenario.users:
        whole, _, _ = _split(user, scenario, ticks, live=live)
        up, down = ticks // user.master.rate_drop, ticks // scenario.period_ticks
        found, signals = found + whole * (up + down), max(signals, min(up, down))
    return found > LARGEST_DENSE * math.sqrt(signals)


def opened(*runs: Scenario, live: bool = False, weights: Sequence[int] = ()) -> Opened:
    """Return the loop of scenarios, opened at links longer than a hyperperiod."""
    scenario, ticks = runs[0], hyperperiod_ticks(runs[0])
    links, whole, ways = [], [], []
    for index, user in enumerate(scenario.users):
        delay, up, down = _split(user, scenario, ticks, live=live)
        if delay:
            # Waves and positions go up, and one of both comes down; waves alone up, too.
            signals = 1 if has_waves(scenario.controller) else 2
            upward = signals * (ticks // user.master.rate_drop) <= ticks // scenario.period_ticks
            ways.append(("up" if upward else "down", index))
            longer = LinkParams(delay_s=(up if upward else down).delay_s + ticks * scenario.tick_s)
            up, down = (longer, down) if upward else (up, longer)
        links.append((up, down))
        whole.append(delay)
    rest = (with_links(run, links) for run in runs)
    model, packets, motions = opened_at(rest, ways, live=live, weights=weights)
    delays, states = np.array([whole[int(path[1])] for path in packets]), len(model.columns)
    given = np.concatenate([model.rows, model.read["sent"]], axis=1)[:, :, states:]
    read = np.flatnonzero(given.any(axis=(0, 1)))  # what of the packets counts
    found = []
    for run, own in enumerate(motions.tolist()):
        system, ones = observable(model, run, read, read)
        found.append(Loci(system, delays[read], max(own - ones, 0)))
    return Opened(found, ticks, int(motions[0]), states + int(delays[read].sum()))


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
    if whole * (ticks // user.master.rate_drop + ticks // scenario.period_ticks) <= SHORT:
        return 0, user.link_up, user.link_down
    return whole, left[0], left[1]


def opened_at(
    runs: Iterable[Scenario],
    ways: Sequence[tuple[str, int]],
    *,
    live: bool = False,
    weights: Sequence[int] = (),
) -> tuple[Linear, list[Path], Integers]:
    """Return a loop whose inputs are packets that come in at links that are cut, and whose output
    ``sent`` are those that go out there instead; what of a packet each of them is; and the number
    of rigid motions of every run while the links are not cut.

    Links are given by their way ("up" or "down") and the number of the user. Their delays are a
    hyperperiod longer than they shall be: so all that is sent there in one is a state.
    """
    loop = checked(*runs, live=live, weights=weights)
    states, paths, rows = list(loop.paths), list(loop.paths.values()), loop.around()[0]
    packets = [
        j for j, path in enumerate(paths) if path[:2] in ways and loop.sent_at(path) >= -loop.ticks
    ]
    motions = model_of(loop, states, rows, {}).quotient[1]
    inside = np.setdiff1d(np.arange(len(states)), packets)
    rows = rows[:, :, [*inside, *packets]]
    sent = {"sent": rows[:, packets]}
    model = model_of(loop, [states[j] for j in inside], rows[:, inside], sent)
    return model, [paths[j] for j in packets], motions


def ends(scenario: Scenario, *, live: bool) -> tuple[System, System]:
    """Return the end of the first user's first axis, and the server's, from and to all users."""
    once = LinkParams(delay_s=(hyperperiod_ticks(scenario) + live) * scenario.tick_s)
    users = range(len(scenario.users))
    ways = [(way, index) for way in ("up", "down") for index in users]
    cut = with_links(scenario, [(once, once) for _ in users])
    model, packets, _ = opened_at([cut], ways, live=live)
    up, down = (
        [j for j, path in enumerate(packets) if path[0] == way and "wave" in path]
        for way in ("up", "down")
    )
    return observable(model, 0, up[:1], down[:1])[0], observable(model, 0, down, up)[0]


def observable(model: Linear, run: int, out: Any, into: Any) -> tuple[System, int]:
    """Return a run of an open loop from packets that come in to those that go out, without the
    states that nothing reads, and how many of those stay where they are: eigenvalues 1.
    """
    rows, sent, n = model.rows[run], model.read["sent"][run], len(model.columns)
    inputs, ones = [n + index for index in into], 0
    a, b, c, d = rows[:, :n], rows[:, inputs], sent[out, :n], sent[np.ix_(out, inputs)]
    while len(a):
        read = np.any(c != 0.0, axis=0)
        read |= np.any((a != 0.0) & ~np.eye(len(a), dtype=np.bool_), axis=0)
        if read.all():
            break
        ones += int(np.count_nonzero(np.diag(a)[~read] == 1.0))
        a, b, c = a[np.ix_(read, read)], b[read], c[:, read]
    return System(a, b, c, d), ones
