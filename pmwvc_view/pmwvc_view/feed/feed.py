# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The feed: traces of all nodes, in blocks as they come, to rows of one time line. No ROS.

Rows lie on a grid of the nodes' monotonic clock. A row is made once every node's trace reaches
it, or ``PATIENCE_NS`` later without those that are late.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pmwvc_core.controllers.library import has_waves
from pmwvc_core.ends.server_view import kept_words, why_kept
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view.feed.balances import Balances, ServerBalance
from pmwvc_view.feed.rows import ROUNDED_S, Source, newest, rows_of
from pmwvc_view.feed.tape import AVATAR, NS, OBJECT, SIGNALS, Tape, TraceBlock, TraceStep, UserTape
from pmwvc_view.protocol.snapshot import ENERGIES, NO_PACKETS, Layout, Snapshot

PATIENCE_NS = 60_000_000
LONGEST_GAP_NS = NS  # where no trace came for longer, the grid begins anew
LOOKED_BACK_S = 1.0  # longer than any block, and than a trace that comes late
LOADED_N = 0.1  # force from which a device counts as loaded
APART_M = 3e-3  # more than a press takes: so far from its avatar a device was when it joined


class FeedUser:
    """What is known of a user at the newest row. ``state``, ``reason``: of its master; None:
    there was no trace, or none for ``GONE_S`` (then it is ``gone``); ``apart``: its avatar is away
    from its device since it joined; ``loaded_change``: tau/(2b) changed under load since the
    device was coupled; ``shown_s``: time of the last tick shown [s].
    """

    def __init__(self, tape: UserTape, layout: Layout, scenario: Scenario) -> None:
        self.balances, self._tape = Balances(), tape
        self.at = {
            column.removeprefix(f"{tape.name}."): where
            for column, where in layout.slices.items()
            if column.startswith(f"{tape.name}.")
        }
        self.avatar_at = layout.together(tape.name, AVATAR)
        self._signals_at = layout.together(tape.name, SIGNALS)
        self._energies_at = layout.together(tape.name, ENERGIES)
        self.state: int | None = None
        self.reason, self.shown_s = "", -math.inf
        self.gone = self.apart = self.loaded_change = self._there = False
        self._give, self._distance_m = math.nan, math.nan  # tau/(2b) by the model [m/N]
        waves, black_box = has_waves(scenario.controller), scenario.coupling.black_box
        self._why_apart = why_kept(waves=waves, black_box=black_box)

    @property
    def kept_apart(self) -> str:
        """How far the avatar is from the device since the user joined, and why; else nothing."""
        return kept_words(self._distance_m, self._why_apart) if self.apart else ""

    def sources(self, since_s: float) -> Iterator[Source]:
        """Yield what rows take from the master's tables."""
        ticks, blocks = self._tape.ticks.since(since_s), self._tape.blocks.since(since_s)
        energies = self.balances.table.rows
        states = [(self.at["state"], blocks[:, 2]), (self.at["missed"], blocks[:, 4])]
        shown = self._signals_at.stop - self._signals_at.start
        yield Source(ticks[:, 0], [(self._signals_at, ticks[:, 2 : 2 + shown])])
        yield Source(blocks[:, 1], states)
        yield Source(energies[:, 0], [(self._energies_at, energies[:, 1:])], math.inf)

    def follow(self, row: Array) -> None:
        """Note what a row says, and complete it; what is kept since joining is no lag."""
        time, of = row[1:2], {name: row[where] for name, where in self.at.items()}
        ticks, blocks = self._tape.ticks.rows, self._tape.blocks.rows
        if (tick := newest(ticks[:, 0], time)[0]) >= 0:
            self.shown_s = float(ticks[tick, 0])
        if (known := np.isfinite(of["state"][0])) or self.state is not None:
            reason = int(blocks[newest(blocks[:, 1], time)[0], 3])
            self.state = int(of["state"][0]) if known else None
            self.reason, self.gone = self._tape.reasons[reason] if known else "", not known
        give = float(of["lag"][0] / (2.0 * of["impedance"][0]))
        if self.state != SafetyState.COUPLED:
            self.loaded_change = False
        elif abs(give - self._give) > 1e-9 and np.linalg.norm(of["f_applied"]) > LOADED_N:
            self.loaded_change = True
        self._give = give
        there = bool(of["presence"][0] > 0.0)
        self._distance_m = math.dist(of["x_s"], of["x_m"])
        self.apart = there and (not self._there or self.apart) and self._distance_m > APART_M
        self._there = there
        if self.apart:
            of["lag"][:] = math.nan


class Feed:
    """Rows of a session from its traces, the ``tape`` of its newest seconds, and what is known of
    its ``users`` by name. ``others`` are values of rows that come from elsewhere, by column.
    """

    def __init__(self, layout: Layout, scenario: Scenario, *, period_ns: int) -> None:
        self._layout, self._period_ns = layout, period_ns
        self._object_at = layout.together("object", OBJECT)
        self.tape = Tape(layout.users, layout.dof)
        self.users = {
            name: FeedUser(tape, layout, scenario) for name, tape in self.tape.users.items()
        }
        self.server = ServerBalance()
        self._due_ns: int | None = None
        self._seq, self._step_s = 0, -math.inf  # time of the last step shown
        self._packets: list[Array] = []
        self.others: Mapping[str, Any] = {}

    def on_master(self, user: str, block: TraceBlock) -> None:
        """Take in a block; an old one is dropped."""
        if block.end_ns > self.tape.users[user].end_ns:
            self._begin(block.start_ns)
            self.tape.add_block(user, block)

    def on_server(self, step: TraceStep) -> None:
        """Take in a step; an old one is dropped."""
        if step.start_ns > self.tape.step_ns:
            self._begin(step.start_ns)
            self.tape.add_step(step)

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
        while self._due_ns is not None and self._ready(self._due_ns, now_ns):
            dues.append(self.tape.seconds(self._due_ns))
            self._due_ns += self._period_ns
        if not dues:
            return []
        self._balance()
        since_s, ends, links = dues[0] - LOOKED_BACK_S, self.tape.users.items(), self.tape.packets
        rows = rows_of(
            np.array(dues), self._layout, self._sources(since_s),
            [tape.loop_ticks(since_s, self.users[name].shown_s) for name, tape in ends],
            [packets.since(since_s)[:, 2:4] for packets in links],
        )  # fmt: skip
        return [self._completed(row) for row in rows]

    def _sources(self, since_s: float) -> Iterator[Source]:
        """Yield what rows take from the tables."""
        steps = self.tape.steps.since(since_s)
        bodies, avatars, presence, contact, *_ = self.tape.parts(steps)
        shown = [(self._object_at, bodies)]
        for index, user in enumerate(self.users.values()):
            shown += [
                (user.at["presence"], presence[:, index]),
                (user.at["contact"], contact[:, index]),
                (user.avatar_at, avatars[:, :, index]),
            ]
            yield from user.sources(since_s)
        yield Source(steps[:, 0], shown)

    def _completed(self, row: Array) -> Snapshot:
        """Return a row with all that is not in traces, and the packets since the last one."""
        self._seq += 1
        row[0] = self._seq
        self._layout.set(row, self.others)
        for user in self.users.values():
            user.follow(row)
        steps = self.tape.steps.since(self._step_s)
        new = steps[(steps[:, 0] > self._step_s) & (steps[:, 0] <= row[1] + ROUNDED_S)]
        if len(new):
            self._step_s = float(new[-1, 0])
            row[self._layout.slices["server.lateness"]] = new[:, 1].max()
        packets, self._packets = self._packets, []
        return Snapshot(row, np.concatenate(packets) if packets else NO_PACKETS)

    def _balance(self) -> None:
        """Form the balances of blocks and steps that are new."""
        since_s = self.tape.end_s - LOOKED_BACK_S
        steps = self.tape.steps.since(since_s)
        if not len(steps):
            return
        ran_s, (*_, lives, sums) = steps[:, 0] + steps[:, 1], self.tape.parts(steps)
        self.server.update(ran_s, lives, sums)
        for index, (name, user) in enumerate(self.users.items()):
            blocks = self.tape.users[name].blocks.since(since_s)[:, 5:]
            own = np.column_stack([ran_s, lives[:, index], sums[:, :, index]])
            user.balances.update(blocks, own)

    def _begin(self, at_ns: int) -> None:
        if self._due_ns is None or at_ns > self._due_ns + LONGEST_GAP_NS:
            self._due_ns = at_ns + self._period_ns

    def _ready(self, due_ns: int, now_ns: int) -> bool:
        ends = [user.end_ns for user in self.tape.users.values()] + [self.tape.step_ns]
        return min(ends) >= due_ns or (max(ends) >= due_ns and now_ns >= due_ns + PATIENCE_NS)
