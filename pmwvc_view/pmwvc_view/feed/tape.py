# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The newest seconds of a running session: blocks of masters, steps of the server and packets of
links as they come, kept as tables, and the traces of a session as views of them.

What the page does not read is taken as nothing: no wave of the server is too long. Times count
from the first trace [s].
"""

import math
from collections.abc import Sequence
from itertools import accumulate, pairwise, starmap
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import PacketTraces, ServerTraces, UserTraces
from pmwvc_view.feed.rows import UserTicks

NS = 1_000_000_000
SPAN_S = 6.0  # of the tables
SIGNALS = ("x_m", "xd_m", "f_h", "f_applied", "u_m", "v_m")
KEPT = (*SIGNALS, "f_m")  # f_m is not shown
F_H, F_APPLIED = SIGNALS.index("f_h"), SIGNALS.index("f_applied")
AVATAR, OBJECT = ("x_s", "xd_s", "f_s"), ("x_o", "xd_o", "target")


class TraceBlock(NamedTuple):
    """Consecutive ticks of a master; ``signals (7, ticks, dof)`` as in ``KEPT``, SI units.

    ``sums`` are running sums at its end [J]: into the way up, out of the way down (NaN: not known
    on its own), work of the device's force against the hand; None: not comparable with the
    server's.
    """

    start_ns: int
    period_ns: int
    signals: Array
    lateness_s: Sequence[float]  # per tick
    state: int
    reason: str
    missed: int
    epoch: int
    sums: tuple[float, float, float] | None

    @property
    def end_ns(self) -> int:
        """Time of the last tick."""
        return self.start_ns + (len(self.lateness_s) - 1) * self.period_ns


class TraceStep(NamedTuple):
    """A step of the server; ``object (3, dof)`` as in ``OBJECT``, ``avatars (3, users, dof)`` as
    in ``AVATAR``, ``sums (2, users)`` of u_s and v_s [J]; the others per user.
    """

    start_ns: int
    epoch: int
    object: Array
    avatars: Array
    state: Sequence[int]
    contact: Sequence[bool]
    lateness_s: float
    sums: Array


class NewestRows:
    """The newest rows of numbers, oldest first: those of the span, and some more. The first number
    of a row is a time that grows.
    """

    def __init__(self, columns: int) -> None:
        self._all, self._end = np.empty((64, columns)), 0

    @property
    def rows(self) -> Array:
        """The rows, without a copy."""
        return self._all[: self._end]

    def since(self, time: float) -> Array:
        """Return the rows from a time on."""
        rows = self.rows
        return rows[rows[:, 0].searchsorted(time) :]

    def add(self, rows: Array) -> None:
        """Add rows; where there is no room, make some, and forget those before the span."""
        if self._end + len(rows) > len(self._all):
            kept = self.since(rows[-1, 0] - SPAN_S)
            self._all, self._end = np.empty((2 * (len(kept) + len(rows)), rows.shape[1])), 0
            self.add(kept)
        self._all[self._end : self._end + len(rows)] = rows
        self._end += len(rows)


class UserTape:
    """One master. ``ticks``: time, lateness [s], signals as in ``KEPT``; ``blocks``: start,
    end [s], state, number of its reason in ``reasons``, ticks missed, and of its sums when the
    last tick ran [s], life of the master (NaN: not comparable), ``TraceBlock.sums`` [J].
    """

    def __init__(self, name: str, dof: int) -> None:
        self.name, self._dof = name, dof
        self.ticks, self.blocks = NewestRows(2 + len(KEPT) * dof), NewestRows(10)
        self.reasons: list[str] = []
        self.end_ns, self._period_ns, self._epoch, self._life = -1, NS, 0, 0

    def add(self, block: TraceBlock, start_s: float) -> None:
        """Add consecutive ticks that begin at a time."""
        if block.reason not in self.reasons:
            self.reasons.append(block.reason)
        self._life += block.epoch != self._epoch
        self.end_ns, self._period_ns, self._epoch = block.end_ns, block.period_ns, block.epoch
        count, period_s = len(block.lateness_s), block.period_ns / NS
        ticks = np.empty((count, self.ticks.rows.shape[1]))
        ticks[:, 0] = start_s + block.period_ns * np.arange(count) / NS
        ticks[:, 1] = block.lateness_s
        ticks[:, 2:] = block.signals.swapaxes(0, 1).reshape(count, -1)
        self.ticks.add(ticks)
        ran_s, end_s = ticks[-1, 0] + block.lateness_s[-1], start_s + count * period_s
        head = (start_s, end_s, block.state, self.reasons.index(block.reason), block.missed, ran_s)
        sums = (math.nan, 0.0, 0.0, 0.0) if block.sums is None else (self._life, *block.sums)
        self.blocks.add(np.array([[*head, *sums]]))

    def loop_ticks(self, since_s: float, shown_s: float) -> UserTicks:
        """Return the ticks from a time on, the last of which was shown then."""
        ticks, first = self.ticks.since(since_s), 2 + F_APPLIED * self._dof
        force = ticks[:, first : first + self._dof]
        return UserTicks(self.name, ticks[:, 0], force, ticks[:, 1], shown_s)

    def traces(self, since_s: float) -> UserTraces | None:
        """Return the whole blocks from a time on; None where there are none."""
        blocks = self.blocks.since(since_s)
        if not len(blocks):
            return None
        ticks, tick_s = self.ticks.since(blocks[0, 0]), self._period_ns / NS
        signals = ticks[:, 2:].reshape(-1, len(KEPT), self._dof)
        of: dict[str, Any] = {name: signals[:, k] for k, name in enumerate(KEPT)}
        return UserTraces(
            name=self.name, tick_s=tick_s, time_s=ticks[:, 0],
            tick=np.rint(ticks[:, 0] / tick_s).astype(np.int64),
            u_m_lp=of["u_m"], lateness_s=ticks[:, 1], compute_s=np.zeros(len(ticks)),
            block_time_s=blocks[:, 1], state=blocks[:, 2].astype(np.int64),
            reason=[self.reasons[number] for number in blocks[:, 3].astype(int).tolist()],
            energy={"u_tx": blocks[:, 7], "device": blocks[:, 9]}, **of,
        )  # fmt: skip


class Tape:
    """All of a session. ``steps``: start, lateness [s], object, avatars, states, contacts, and of
    their sums the lives of the counters, u_s, v_s [J]; ``packets``, by link: when told [s],
    number, sent, arrived [s], fate. ``zero_ns`` is when time begins, None before; ``end_s`` that
    of the newest tick, ``step_ns`` that of the newest step.
    """

    def __init__(self, users: Sequence[str], dof: int) -> None:
        self.users = {name: UserTape(name, dof) for name in users}
        count = len(users)
        shapes = ((3, dof), (3, count, dof), (count,), (count,), (count,), (2, count))
        ends = list(accumulate((math.prod(shape) for shape in shapes), initial=2))
        self._parts = list(zip(starmap(slice, pairwise(ends)), shapes, strict=True))
        self.steps = NewestRows(ends[-1])
        self.packets = [NewestRows(5) for _ in range(2 * count)]
        self.zero_ns: int | None = None
        self.end_s, self.step_ns = 0.0, -1
        self._epoch, self._lives, self._sums = 0, np.zeros(count), np.zeros((2, count))

    def seconds(self, time_ns: int) -> float:
        """Return a time of the nodes' clock [s]; the first one asked for is zero."""
        if self.zero_ns is None:
            self.zero_ns = time_ns
        return (time_ns - self.zero_ns) / NS

    def add_block(self, user: str, block: TraceBlock) -> None:
        """Add consecutive ticks of a master."""
        self.users[user].add(block, self.seconds(block.start_ns))
        self.end_s = max(self.end_s, self.seconds(block.end_ns))

    def add_step(self, step: TraceStep) -> None:
        """Add a step of the server; sums that fall begin anew, as those of another epoch."""
        self._lives = self._lives + (
            (step.sums < self._sums).any(axis=0) | (step.epoch != self._epoch)
        )
        self.step_ns, self._epoch, self._sums = step.start_ns, step.epoch, step.sums
        head: Any = (self.seconds(step.start_ns), step.lateness_s)
        shown = np.ravel(step.object), np.ravel(step.avatars), step.state, step.contact
        row = np.concatenate([head, *shown, self._lives, np.ravel(step.sums)])
        self.steps.add(row[np.newaxis])

    def add_packets(self, link: int, packets: Array) -> None:
        """Add packets of a link: number, sent, arrived [s], fate."""
        told_s = np.full(len(packets), self.end_s)
        self.packets[link].add(np.column_stack([told_s, packets]))

    def user_traces(self, since_s: float) -> list[UserTraces]:
        """Return the traces of the users from a time on."""
        found = (user.traces(since_s) for user in self.users.values())
        return [traces for traces in found if traces is not None]

    def parts(self, steps: Array) -> list[Array]:
        """Return what is in rows of ``steps``, ``(rows, ...)`` each, without their heads."""
        return [steps[:, where].reshape(-1, *shape) for where, shape in self._parts]

    def server_traces(self, since_s: float, period_s: float) -> ServerTraces | None:
        """Return the steps of the server from a time on; None where there are none."""
        steps = self.steps.since(since_s)
        if not len(steps):
            return None
        bodies, avatars, state, contact, _, sums = self.parts(steps)
        times_s, users, nothing = steps[:, 0], range(len(self.users)), np.zeros(len(steps))
        of: dict[str, Any] = {name: bodies[:, k] for k, name in enumerate(OBJECT)}
        of |= {name: [avatars[:, k, i] for i in users] for k, name in enumerate(AVATAR)}
        silent = [np.zeros_like(avatars[:, 0, i]) for i in users]
        return ServerTraces(
            users=list(self.users), periods_s=np.full(len(steps), period_s), time_s=times_s,
            step=np.rint(times_s / period_s).astype(np.int64), u_s=silent, v_s=silent,
            contact=list(contact.T > 0.0), state=list(state.T.astype(np.int64)),
            energy_u_s=list(sums[:, 0].T), energy_v_s=list(sums[:, 1].T), kinetic=nothing,
            potential=nothing, dissipated=nothing, **of,
        )  # fmt: skip

    def links(self, scenario: Scenario, since_s: float) -> dict[str, PacketTraces]:
        """Return the packets that came out of each link, told from a time on."""
        found = {}
        for link, table in enumerate(self.packets):
            rows = table.since(since_s)
            rows = rows[np.isfinite(rows[:, 3])]
            if not len(rows):
                continue
            user, count, none = scenario.users[link // 2], len(rows), np.zeros((len(rows), 1))
            topic = f"/{user.name}/wave_down" if link % 2 else f"/server/{user.name}/wave_up"
            due_s = scenario.server.period_s if link % 2 else user.master.frame_s
            found[topic] = PacketTraces(
                topic=topic, time_s=rows[:, 3], epoch=np.zeros(count, dtype=np.uint64),
                seq=rows[:, 1].astype(np.int64), sent_ns=np.zeros(count, dtype=np.int64),
                period_s=np.full(count, due_s), wave=none, integral=none, energy=np.zeros(count),
                position=none,
            )  # fmt: skip
        return found
