# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The feed: traces of all nodes as they come, to rows of one time line. No ROS.

Rows lie on a grid of the nodes' monotonic clock. A row is made once every node's trace reaches
it, or ``PATIENCE_S`` later without those that are late.

Energy is judged as the report judges it, over the newest second, again and again; the nodes'
counters are sums since their start. Once a node is started again, or a user comes back, what was
on its way then is in one counter only: its balances are no longer judged.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pmwvc_analysis.budget.criterion import Finding
from pmwvc_analysis.budget.energy import UserEnergy
from pmwvc_analysis.verdicts.passivity import passivity
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.ends.server_end import kept_words
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces
from pmwvc_view.feed.rows import ROUNDED_S, Samples, energies, newest, rows_of, samples
from pmwvc_view.feed.tape import NS, Tape
from pmwvc_view.protocol.snapshot import NO_PACKETS, Layout, Snapshot

PATIENCE_S = 0.06
LONGEST_GAP_S = 1.0  # where no trace came for longer, the grid begins anew
BALANCED_S = 0.1  # between two balances
APART_M = 3e-3  # more than a press takes: so far from its avatar a device was when it joined


class FeedUser:
    """What is known of a user at the newest row. ``energy``: its newest balances, None where none
    is known, ``least_j``: the least of each part [J]; ``judged``: both counters are in their first
    life. ``state``, ``reason``: of its master; None: there was no trace, or none for ``GONE_S``
    (then it is ``gone``); ``apart``: its avatar is away from its device since it joined;
    ``shown_s``: time of the last tick shown [s].
    """

    def __init__(self, name: str, layout: Layout, scenario: Scenario) -> None:
        self.energy: UserEnergy | None = None
        self.judged, self.least_j = True, dict[str, float]()
        self._at = {
            column.removeprefix(f"{name}."): where
            for column, where in layout.slices.items()
            if column.startswith(f"{name}.")
        }
        self.state: int | None = None
        self.reason, self.shown_s = "", -math.inf
        self.gone = self.apart = self._there = False
        self._distance_m = math.nan
        self._kind = {"waves": has_waves(scenario.controller)}
        self._kind["black_box"] = scenario.coupling.black_box

    @property
    def kept_apart(self) -> str:
        """How far the avatar is from the device since the user joined, and why; else nothing."""
        return kept_words(self._distance_m, **self._kind) if self.apart else ""

    @property
    def known(self) -> bool:
        """Whether there is a balance."""
        return self.energy is not None and bool(np.isfinite(self.energy.joint.balance_j).all())

    @property
    def channel_known(self) -> bool:
        """Whether the energy of both directions is known on its own."""
        return self.known and self.energy is not None and self.energy.down is not None

    def begin_anew(self) -> None:
        """Note that a counter began anew."""
        self.energy, self.judged = None, False

    def account(self, energy: UserEnergy) -> None:
        """Take in the balances of the newest second."""
        if not self.judged or not len(energy.joint.time_s):
            return
        begun = [each.balance_j[0] < each.limit_j[0] for each in energy.parts.values()]
        if self.energy is None and any(begun):  # of counters that began at different times
            self.judged = False
            return
        self.energy = energy
        for part, balance in energy.parts.items():
            self.least_j[part] = min(self.least_j.get(part, 0.0), balance.minimum_j)

    def follow(self, row: Array, traces: UserTraces) -> None:
        """Note what a row says, and complete it; what is kept since joining is no lag."""
        time, of = row[1:2], {name: row[where] for name, where in self._at.items()}
        if (tick := newest(traces.time_s, time)[0]) >= 0:
            self.shown_s = float(traces.time_s[tick])
        if (known := np.isfinite(of["state"][0])) or self.state is not None:
            self.state = int(of["state"][0]) if known else None
            reason = traces.reason[newest(traces.block_time_s, time)[0]] if known else ""
            self.reason, self.gone = reason, not known
        there = bool(of["presence"][0] > 0.0)
        self._distance_m = math.dist(of["x_s"], of["x_m"])
        self.apart = there and (not self._there or self.apart) and self._distance_m > APART_M
        self._there = there
        if self.apart:
            of["lag"][:] = math.nan


class Feed:
    """Rows of a session from its traces, the ``tape`` of its newest seconds, and what is known of
    its ``users`` by name. ``worst``: of each account, by owner and part, the finding that was
    nearest to its limit, or farthest below. ``others`` are values of rows that come from
    elsewhere, by column.
    """

    def __init__(
        self, layout: Layout, scenario: Scenario, *, period_ns: int, live: bool = False
    ) -> None:
        self._layout, self._scenario, self._period_ns = layout, scenario, period_ns
        self.tape = Tape(scenario, live=live)
        self.users = {name: FeedUser(name, layout, scenario) for name in self.tape.users}
        self.worst: dict[tuple[str, str], Finding] = {}
        self.server_judged = True
        self._due_ns: int | None = None  # since time began
        self._seq, self._balanced_s = 0, -math.inf
        self._packets: list[Array] = []
        self.others: Mapping[str, Any] = {}

    def on_master(self, traces: UserTraces) -> None:
        """Take in traces; what is old of them is dropped."""
        if (both := self.tape.users[traces.name].add(traces)) is not None:
            self._begin(float(traces.time_s[0]))
            if (np.diff(both.tick) < 0).any():
                self.users[traces.name].begin_anew()

    def on_server(self, traces: ServerTraces) -> None:
        """Take in traces; what is old of them is dropped."""
        if (both := self.tape.server.add(traces)) is None:
            return
        self._begin(float(traces.time_s[0]))
        again = (np.diff(both.step) < 0).any()
        for name, *sums in zip(both.users, both.energy_u_s, both.energy_v_s, strict=True):
            if again or (np.diff(sums) < 0.0).any():
                self.users[name].begin_anew()
                self.server_judged = False

    def on_packets(self, link: int, columns: Array) -> None:
        """Take in packets of a link, ``(n, 4)``: number, time in and out [ns] (0: never), fate."""
        if (zero_ns := self.tape.zero_ns) is None or not len(columns):
            return
        number, in_ns, out_ns, fate = columns.T
        arrived_s = np.where(out_ns > 0, (out_ns - zero_ns) / NS, math.nan)
        packets = np.column_stack([number, (in_ns - zero_ns) / NS, arrived_s, fate])
        self.tape.add_packets(link, packets)
        self._packets.append(np.insert(packets, 0, link, axis=1))

    def rows(self, now_ns: int) -> list[Snapshot]:
        """Return the rows that are due at a time of the nodes' clock."""
        dues = []
        while self._due_ns is not None and self._ready(self._due_ns / NS, now_ns):
            dues.append(self._due_ns / NS)
            self._due_ns += self._period_ns
        if not dues:
            return []
        shown = self.tape.shown()
        if self.tape.end_s >= self._balanced_s + BALANCED_S:
            self._balanced_s = self.tape.end_s
            judged = passivity(shown, self._scenario, None)
            for energy in judged.users:
                self.users[energy.name].account(energy)
            for found in judged.ports:
                key, owner = (found.owner, found.part), self.users.get(found.owner)
                if owner.known if owner else self.server_judged:
                    self.worst[key] = min(self.worst.get(key, found), found, key=_margin_j)
        rows = rows_of(
            np.array(dues),
            self._layout,
            self._samples(shown),
            shown.users,
            [packets[:, 1:3] for packets in self.tape.packets],
            {name: user.shown_s for name, user in self.users.items()},
        )
        return [self._completed(row, shown) for row in rows]

    def _samples(self, shown: SessionTraces) -> Iterator[Samples]:
        yield from samples(shown)
        for user in self.users.values():
            if user.energy is not None:
                yield from energies(user.energy, user.least_j)

    def _completed(self, row: Array, shown: SessionTraces) -> Snapshot:
        """Return a row with all that is not in traces, and the packets since the last one."""
        self._seq += 1
        row[0] = self._seq
        self._layout.set(row, self.others)
        for user in shown.users:
            self.users[user.name].follow(row, user)
        every, self._packets = np.concatenate([NO_PACKETS, *self._packets]), []
        return Snapshot(row, every)

    def _begin(self, at_s: float) -> None:
        if self._due_ns is None or at_s > self._due_ns / NS + LONGEST_GAP_S:
            self._due_ns = round(at_s * NS) + self._period_ns

    def _ready(self, due_s: float, now_ns: int) -> bool:
        ends = [*(user.end_s for user in self.tape.users.values()), self.tape.server.end_s]
        due_s -= ROUNDED_S
        now_s = (now_ns - self.tape.zero(now_ns)) / NS
        return min(ends) >= due_s or (max(ends) >= due_s and now_s >= due_s + PATIENCE_S)


def _margin_j(found: Finding) -> float:
    """Return how far a balance stayed above its limit [J]."""
    return found.least_j + found.tolerance_j + found.declared_j + found.counts_j
