# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy balances of one user while a session runs: up, down, and from hand to object.

Two nodes count each on its own, and counters read at two instants give balances below zero though
nothing is active. So a balance is formed at the end of a block of the master, with the last step
of the server that ran before: cause is never behind effect. (A recorded session is judged the same
way, at the server's steps: :mod:`pmwvc_analysis.budget.energy`.) Once a counter begins anew, what
was on its way then is in one of the two only: the sums go on from zero and are no longer judged.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.budget.criterion import tolerance
from pmwvc_analysis.traces.thresholds import TOLERANCE_J
from pmwvc_core.controllers.accounts import NODE, OF_STRICT, RELEASED
from pmwvc_core.numeric import Array
from pmwvc_view.feed.tape import NewestRows

NO_WAVES = math.nan, math.nan
_STRICT = frozenset(entry.name for entry in OF_STRICT)
WAYS = ("way up", "way down", "hand to object")


def ways(u_m: float, u_tx: float, v_m: float, kept: Mapping[str, float]) -> tuple[float, float]:
    """Return what went into the way up and came out of the way down at a device [J]; NaN where
    that is not known on its own: something at the device answers or alters the wave. ``u_m``,
    ``u_tx`` and ``v_m`` are the energies of the waves out of its port, sent, and into its port
    [J]; ``kept`` is what the controller keeps account of beside them, by name [J]. On the strict
    channel packets were paid with ``u_tx``, and the playout released energy beside its wave.
    """
    if NODE.name in kept:
        altered = not kept.keys() <= _STRICT
        return u_tx, math.nan if altered else v_m + kept[RELEASED.name]
    return NO_WAVES if kept else (u_m, v_m)


class Worst(NamedTuple):
    """The balance nearest to its tolerance, or farthest below: a deficit is compared with the
    tolerance of its own time, however much energy is moved later.
    """

    margin_j: float = TOLERANCE_J  # balance and tolerance
    balance_j: float = 0.0
    time_s: float = 0.0

    def or_lower(self, balance_j: Array, came_j: Array, times_s: Array) -> "Worst":
        """Return the worst of this and of balances in which so much came in, each ``(rows,)``."""
        margin = balance_j + tolerance(came_j)
        row = int(margin.argmin())  # not a number: never below
        found = Worst(*map(float, (margin[row], balance_j[row], times_s[row])))
        return found if found.margin_j < self.margin_j else self


class ServerBalance:
    """What the server took in at all ports less what it gave, until a counter begins anew."""

    def __init__(self) -> None:
        self.worst = Worst()
        self._until_s, self._lives = -math.inf, np.zeros(0)

    def update(self, ran_s: Array, lives: Array, sums: Array) -> None:
        """Balance the steps that are new: when run [s], ``(steps,)``, lives of the counters,
        ``(steps, users)``, sums of u_s and v_s [J], ``(steps, 2, users)``.
        """
        self._lives = self._lives if len(self._lives) else lives[0]
        new = (ran_s > self._until_s) & (lives == self._lives).all(axis=1)
        if not new.any():
            return
        times_s, (took, gave) = ran_s[new], sums[new].sum(axis=2).T
        self._until_s = float(times_s[-1])
        self.worst = self.worst.or_lower(took - gave, took, times_s)


class Balances:
    """See above. ``table``: time, then of each way energy in, energy out and the lowest balance so
    far [J], NaN where it is not known on its own; ``judged``: both counters are in their first
    life; ``worst`` of each of ``WAYS``.
    """

    def __init__(self) -> None:
        self.table, self.judged = NewestRows(1 + 3 * len(WAYS)), True
        self.worst = dict.fromkeys(WAYS, Worst())
        self._until_s, self._lives = -math.inf, (math.nan, math.nan)
        self._begin, self._least = np.zeros(2 * len(WAYS)), np.zeros(len(WAYS))

    @property
    def known(self) -> bool:
        """Whether there is a balance."""
        return self._until_s > -math.inf

    @property
    def channel_known(self) -> bool:
        """Whether the energy of both directions is known on its own."""
        return self.known and bool(np.isfinite(self.table.rows[-1, 1:7]).all())

    def update(self, blocks: Array, steps: Array) -> None:
        """Balance the blocks that are new and behind which a step is known; either node's may come
        later than the other's. ``blocks (n, 5)``: when run [s], life (NaN: not comparable), sums
        up, down and of the work [J]; ``steps (m, 4)``: when run, life, sums of u_s and v_s.
        """
        ran_s = blocks[:, 0]
        new = (ran_s > self._until_s) & (ran_s < steps[-1, 0]) & np.isfinite(blocks[:, 1])
        fresh = blocks[new & (ran_s > steps[0, 0])]
        if not len(fresh):
            return
        before = steps[steps[:, 0].searchsorted(fresh[:, 0]) - 1]
        self._until_s = float(fresh[-1, 0])
        (ran_s, life, up, down, work), (_, other, u_s, v_s) = fresh.T, before.T
        sums = np.column_stack([up, u_s, v_s, down, work, u_s - v_s])
        lives = list(zip(life.tolist(), other.tolist(), strict=True))
        begins = [k for k in range(1, len(lives)) if lives[k] != lives[k - 1]]
        for first, last in zip([0, *begins], [*begins, len(lives)], strict=True):
            self._live(ran_s[first:last], lives[first], sums[first:last])

    def _live(self, ran_s: Array, lives: tuple[float, float], sums: Array) -> None:
        """Note sums ``(blocks, 6)``, in and out of every way, of one life of both counters."""
        if math.isnan(self._lives[0]):
            # Of counters that began at different times one shows more than the other can have.
            first = sums[0, ::2] - sums[0, 1::2]
            channel = first[:2][np.isfinite(first[:2])]
            self.judged = not min(channel if len(channel) else first[2:]) < -TOLERANCE_J
        elif lives != self._lives:
            self._begin, self.judged = sums[0], False
        self._lives = lives
        moved = sums - self._begin
        came, went = moved[:, ::2], moved[:, 1::2]
        balance = came - went
        if self.judged:
            least = np.fmin(np.fmin.accumulate(balance), self._least)
            self._least = least[-1]
            for way, name in enumerate(WAYS):
                self.worst[name] = self.worst[name].or_lower(balance[:, way], came[:, way], ran_s)
        else:
            least = self._least
        table, unknown = np.empty((len(sums), 1 + 3 * len(WAYS))), balance - balance
        table[:, 0] = ran_s
        for column, values in enumerate((came, went, least), start=1):
            table[:, column::3] = values + unknown
        self.table.add(table)
