# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The feed: traces of all nodes, in blocks as they come, to rows of one time line. No ROS.

Rows lie on a grid of the nodes' monotonic clock. A row is made once every node's trace reaches
it, or ``PATIENCE_NS`` later without those that are late; it holds the newest tick of each master
and the newest step of the server at its time, and the extremes of the 1 kHz force since the row
before.
"""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.master.safety_states import SafetyState
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_view.accounts import Account, Accounts, MasterSums, ServerSums
from pmwvc_view.protocol.snapshot import PACKET, Layout
from pmwvc_view.shaking import Shaking
from pmwvc_view.snapshots import Snapshot

NS = 1_000_000_000
PATIENCE_NS = 60_000_000
LONGEST_GAP_NS = NS  # where no trace came for longer, the grid begins anew
DELAYS = 64  # newest packets of a link of which the delay is the mean
LOADED_N = 0.1  # force from which a device counts as loaded


class Block(NamedTuple):
    """Consecutive ticks of a master; arrays ``(ticks, dof)``, SI units."""

    start_ns: int
    period_ns: int
    x: Array
    xd: Array
    f_h: Array
    f_applied: Array
    u_m: Array
    v_m: Array
    lateness_s: Array
    state: int
    reason: str
    missed: int
    sums: MasterSums | None  # None: not comparable with the server's
    waves: bool  # the channel's directions can be told apart

    @property
    def end_ns(self) -> int:
        """Time of the last tick."""
        return self.start_ns + (len(self.lateness_s) - 1) * self.period_ns


class Step(NamedTuple):
    """A step of the server; ``(users, dof)`` or ``(users,)``, the object's ``(dof,)``."""

    start_ns: int
    x_o: Array
    xd_o: Array
    target: Array
    x_s: Array
    xd_s: Array
    f_s: Array
    state: Sequence[int]
    contact: Sequence[bool]
    lateness_s: float
    sums: Mapping[str, ServerSums]  # by user


class _User:
    """What is known of one user at the newest row."""

    def __init__(self, shaking: Shaking) -> None:
        self.blocks: deque[Block] = deque()
        self.shaking = shaking
        self.in_contact = False
        self.lag_s = math.nan  # by the model
        self.loaded_change = False  # of the lag, since it was coupled
        self.accounts = Accounts()
        self.end_ns = -1  # of the newest block
        self.values: dict[str, Any] = {}  # of the newest tick
        self.waves = False
        self.reason = ""

    def advance(self, until_ns: int) -> dict[str, Any]:
        """Return the values of the ticks up to a time, newest and extreme."""
        forces, late = [], 0.0
        while self.blocks and self.blocks[0].start_ns <= until_ns:
            block = self.blocks[0]
            count = min((until_ns - block.start_ns) // block.period_ns + 1, len(block.x))
            forces.append(block.f_applied[:count])
            late = max(late, float(block.lateness_s[:count].max()))
            names = ("x", "xd", "f_h", "f_applied", "u_m", "v_m")
            last = {name: getattr(block, name)[count - 1] for name in names}
            self.values = {"x_m": last.pop("x"), "xd_m": last.pop("xd"), **last}
            self.values |= {"state": block.state, "missed": block.missed}
            self.waves, self.reason = block.waves, block.reason
            if count < len(block.x):
                self.blocks[0] = _rest(block, int(count))
                break
            self.blocks.popleft()
        if not forces:
            return self.values
        every = np.concatenate(forces)
        extremes = {"f_min": every.min(axis=0), "f_max": every.max(axis=0), "lateness": late}
        return {**self.values, **extremes}

    def follow_lag(self, lag_s: float) -> None:
        """Note the lag of a row [s], and whether it changed under load."""
        loaded = np.linalg.norm(self.values.get("f_applied", 0.0)) > LOADED_N
        if self.values.get("state") != SafetyState.COUPLED:
            self.loaded_change = False
        elif loaded and abs(lag_s - self.lag_s) > 1e-9:
            self.loaded_change = True
        self.lag_s = lag_s


class Feed:
    """Rows of a session from its traces.

    Parameters
    ----------
    layout
        Of the rows.
    users
        Names of the users, in order.
    period_ns
        Between two rows.
    scenario
        Tells what motion is on purpose; None: not known.

    Attributes
    ----------
    zero_ns
        Time of the first trace; the rows' time counts from there. None before.
    """

    def __init__(
        self,
        layout: Layout,
        users: Sequence[str],
        *,
        period_ns: int,
        scenario: Scenario | None = None,
    ) -> None:
        self._layout = layout
        self._users = {name: _User(Shaking(scenario, name)) for name in users}
        self._period_ns = period_ns
        self._steps: deque[Step] = deque()
        self._step: Step | None = None
        self._step_end_ns = -1
        self._due_ns: int | None = None
        self._seq = 0
        self._packets: list[Array] = []
        self._delays = {
            2 * i + way: deque[float](maxlen=DELAYS) for i in range(len(users)) for way in (0, 1)
        }
        self.zero_ns: int | None = None
        self.others: dict[str, Any] = {}  # by column: values that come from elsewhere

    def on_master(self, user: str, block: Block) -> None:
        """Take in a block; an old one is dropped."""
        one = self._users[user]
        if block.end_ns <= one.end_ns:
            return
        self._begin(block.start_ns)
        one.end_ns = block.end_ns
        one.blocks.append(block)
        one.shaking.block(block.start_ns, block.period_ns, block.xd, block.f_applied)
        if block.sums is not None:
            one.accounts.block(block.sums)

    def on_server(self, step: Step) -> None:
        """Take in a step; an old one is dropped."""
        if step.start_ns <= self._step_end_ns:
            return
        self._begin(step.start_ns)
        self._step_end_ns = step.start_ns
        self._steps.append(step)
        for name, sums in step.sums.items():
            if name in self._users:
                self._users[name].accounts.step(sums)
        for one, contact in zip(self._users.values(), step.contact, strict=False):
            if contact != one.in_contact:
                one.in_contact = contact
                one.shaking.contact(step.start_ns)

    def on_packets(self, link: int, columns: Array) -> None:
        """Take in packets of a link, ``(n, 4)``: number, time in and out [ns] (0: never), fate."""
        if self.zero_ns is None or not len(columns):
            return
        rows = np.empty((len(columns), len(PACKET)))
        rows[:, 0] = link
        rows[:, 1] = columns[:, 0]
        rows[:, 2] = (columns[:, 1] - self.zero_ns) / NS
        rows[:, 3] = np.where(columns[:, 2] > 0, (columns[:, 2] - self.zero_ns) / NS, math.nan)
        rows[:, 4] = columns[:, 3]
        self._packets.append(rows)
        taken = rows[:, 3] - rows[:, 2]
        self._delays[link].extend(taken[np.isfinite(taken)].tolist())

    def accounts(self, user: str) -> Accounts:
        """Return the energy accounts of a user."""
        return self._users[user].accounts

    def shaking(self, user: str) -> Shaking:
        """Return whether a user's device shakes."""
        return self._users[user].shaking

    def loaded_change(self, user: str) -> bool:
        """Tell whether a user's delay changed while its device was coupled and loaded."""
        return self._users[user].loaded_change

    def waves(self, user: str) -> bool:
        """Tell whether the directions of a user's channel can be told apart."""
        return self._users[user].waves

    def state(self, user: str) -> tuple[int | None, str]:
        """Return the state of a user's master, and why it is so; None before its first block."""
        one = self._users[user]
        return one.values.get("state"), one.reason

    def rows(self, now_ns: int) -> list[Snapshot]:
        """Return the rows that are due at a time of the nodes' clock."""
        found: list[Snapshot] = []
        while self._due_ns is not None and self._ready(self._due_ns, now_ns):
            found.append(self._row(self._due_ns))
            self._due_ns += self._period_ns
        return found

    def _begin(self, at_ns: int) -> None:
        if self.zero_ns is None:
            self.zero_ns = at_ns
        if self._due_ns is None or at_ns > self._due_ns + LONGEST_GAP_NS:
            self._due_ns = at_ns + self._period_ns

    def _ready(self, due_ns: int, now_ns: int) -> bool:
        ends = [one.end_ns for one in self._users.values()] + [self._step_end_ns]
        return min(ends) >= due_ns or (max(ends) >= due_ns and now_ns >= due_ns + PATIENCE_NS)

    def _row(self, due_ns: int) -> Snapshot:
        """Return the row at a time."""
        self._seq += 1
        row = self._layout.row()
        values: dict[str, Any] = {"seq": self._seq, "time_s": (due_ns - (self.zero_ns or 0)) / NS}
        late = None
        while self._steps and self._steps[0].start_ns <= due_ns:
            self._step = self._steps.popleft()
            late = max(late or 0.0, self._step.lateness_s)
        step = self._step
        if step is not None:
            values |= {"object.x_o": step.x_o, "object.xd_o": step.xd_o}
            values |= {"object.target": step.target, "server.lateness": late}
        for index, (name, one) in enumerate(self._users.items()):
            found = one.advance(due_ns)
            if step is not None and index < len(step.state):
                found |= {"x_s": step.x_s[index], "xd_s": step.xd_s[index], "f_s": step.f_s[index]}
                found |= {"presence": step.state[index], "contact": step.contact[index]}
            found |= _energies(one)
            for way, link in (("delay_up", 2 * index), ("delay_down", 2 * index + 1)):
                if delays := self._delays[link]:
                    found[way] = sum(delays) / len(delays)
            lag_s = self.others.get(f"{name}.lag")
            one.follow_lag(math.nan if lag_s is None else lag_s)
            values |= {f"{name}.{column}": value for column, value in found.items()}
        self._layout.set(row, values | self.others)
        packets, self._packets = self._packets, []
        rows = np.concatenate(packets) if packets else np.empty((0, len(PACKET)))
        return Snapshot(row, rows)


def _energies(one: _User) -> dict[str, float]:
    """Return the accounts of a user by column; none before the first balance."""
    accounts = one.accounts
    if accounts.known_ns is None:
        return {}
    named: dict[str, Account] = {"hand": accounts.hand}
    if one.waves:
        named |= {"up": accounts.up, "down": accounts.down}
    return {
        f"energy_{name}_{column}": value
        for name, account in named.items()
        for column, value in (
            ("in", account.in_j),
            ("out", account.out_j),
            ("min", account.least_j),
        )
    }


def _rest(block: Block, count: int) -> Block:
    """Return a block without its first ticks."""
    names = ("x", "xd", "f_h", "f_applied", "u_m", "v_m", "lateness_s")
    cut = {name: getattr(block, name)[count:] for name in names}
    return block._replace(start_ns=block.start_ns + count * block.period_ns, **cut)
