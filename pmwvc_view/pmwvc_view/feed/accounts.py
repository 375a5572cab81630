# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy accounts of one user while a session runs: up, down, and from hand to object.

The account up is the energy that went into the waves at the device less what the server had of
them; down, likewise. On the strict channel that is what packets were paid with, and the playout's
wave with what the playout released beside it. Where something at the device answers or alters the
wave, what went up or came down there is not known on its own.

Two nodes count each on its own. Counters read at two instants give balances below zero although
nothing is active, so a balance is formed at the end of a block of the master, with the last step
of the server that ran before: what the master sent counts once its tick has run, what the server
made of it with its step, so cause is never behind effect. (A recorded session is judged the same
way, at the server's steps: :mod:`pmwvc_analysis.budget.energy`.)

Balances are judged as long as both counters are in their first life. Once one of them begins anew
(a node was started again, a user came back), what was on its way then is in one of the two only:
the sums go on from zero, and the lowest balance stays what it was.
"""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from pmwvc_analysis.traces.thresholds import TOLERANCE_J, TOLERANCE_RELATIVE
from pmwvc_core.controllers.accounts import NODE, OF_STRICT, RELEASED

LONGEST = 512  # blocks or steps that wait for the other node


class MasterSums(NamedTuple):
    """Running sums of a master at the end of a block [J], and when its last tick ran [ns].

    ``up`` went into the way up, ``down`` came out of the way down (NaN: not known on its own),
    ``device`` is the work of the device's force against the hand.
    """

    ran_ns: int
    epoch: int
    up: float
    down: float
    device: float


NO_WAVES = math.nan, math.nan
_STRICT = frozenset(entry.name for entry in OF_STRICT)


def ways(u_m: float, u_tx: float, v_m: float, kept: Mapping[str, float]) -> tuple[float, float]:
    """Return what went into the way up and came out of the way down at a device [J]; NaN where
    that is not known on its own.

    Parameters
    ----------
    u_m, u_tx, v_m
        Energy of the waves out of the device's port, of those sent, and of those into the port
        [J].
    kept
        What the controller keeps account of beside them, by name [J].
    """
    if NODE.name in kept:
        altered = not kept.keys() <= _STRICT
        return u_tx, math.nan if altered else v_m + kept[RELEASED.name]
    return NO_WAVES if kept else (u_m, v_m)


class ServerSums(NamedTuple):
    """Running sums of a user's port at the server after a step [J], and when it ran [ns]."""

    ran_ns: int
    epoch: int
    u_s: float
    v_s: float


@dataclass
class PageBalance:
    """Energy into and out of a part since the start, and the lowest balance seen [J].

    ``margin_j`` is the least that a balance was above minus its tolerance, ``least_j`` that
    balance: a deficit is compared with the tolerance of its own time, however much energy is
    moved later.
    """

    in_j: float = 0.0
    out_j: float = 0.0
    least_j: float = 0.0
    least_ns: int = 0  # when
    margin_j: float = TOLERANCE_J

    @property
    def known(self) -> bool:
        """Whether both sums are known on their own."""
        return math.isfinite(self.in_j - self.out_j)

    def at(self, now_ns: int, in_j: float, out_j: float, *, judged: bool) -> None:
        """Note both sums at a time [ns]; a balance that is not judged, or not known, is never the
        lowest.
        """
        self.in_j, self.out_j = in_j, out_j
        balance_j = in_j - out_j
        margin_j = balance_j + TOLERANCE_J + TOLERANCE_RELATIVE * abs(in_j)
        if judged and balance_j < 0.0 and margin_j < self.margin_j:
            self.margin_j, self.least_j, self.least_ns = margin_j, balance_j, now_ns


class PageBalances:
    """The accounts of one user, from the sums of both ends.

    Attributes
    ----------
    known_ns
        Time of the newest balance [ns]; None before the first.
    judged
        Whether they are judged: both counters are in their first life.
    """

    def __init__(self) -> None:
        self.up, self.down, self.hand = PageBalance(), PageBalance(), PageBalance()
        self.known_ns: int | None = None
        self.judged = True
        self._waiting: deque[MasterSums] = deque(maxlen=LONGEST)
        self._steps: deque[ServerSums] = deque(maxlen=LONGEST)
        self._life: tuple[int, int] | None = None  # epochs of both ends
        self._begin: tuple[MasterSums, ServerSums] | None = None

    def block(self, sums: MasterSums) -> None:
        """Take in a block of the master; blocks come in the order of time."""
        self._waiting.append(sums)
        self._pair()

    def step(self, sums: ServerSums) -> None:
        """Take in a step of the server; steps come in the order of time."""
        self._steps.append(sums)
        self._pair()

    def _pair(self) -> None:
        """Balance each block with the last step that ran before it, once a later step is known.

        Either node's traces may come later than the other's.
        """
        steps, waiting = self._steps, self._waiting
        while waiting and steps and steps[-1].ran_ns > waiting[0].ran_ns:
            block = waiting.popleft()
            while len(steps) > 1 and steps[1].ran_ns < block.ran_ns:
                before = steps.popleft()
                if steps[0].u_s < before.u_s or steps[0].v_s < before.v_s:
                    self._life = None  # counts from zero again
            if steps[0].ran_ns < block.ran_ns:
                self._balance(block, steps[0])

    def _balance(self, block: MasterSums, step: ServerSums) -> None:
        life = (block.epoch, step.epoch)
        if self._begin is None:
            zero = block._replace(up=0.0, down=0.0, device=0.0), step._replace(u_s=0.0, v_s=0.0)
            self._begin = zero
            # Of counters that began at different times one shows more than the other can have.
            hand = block.device - step.u_s + step.v_s
            both = [block.up - step.u_s, step.v_s - block.down]
            known = [each for each in both if math.isfinite(each)] or [hand]
            self.judged = not min(known) < -TOLERANCE_J
        elif life != self._life:
            self._begin, self.judged = (block, step), False
        self._life = life
        from_block, from_step = self._begin
        u_s, v_s = step.u_s - from_step.u_s, step.v_s - from_step.v_s
        self.up.at(block.ran_ns, block.up - from_block.up, u_s, judged=self.judged)
        self.down.at(block.ran_ns, v_s, block.down - from_block.down, judged=self.judged)
        work = block.device - from_block.device
        if math.isfinite(work):
            self.hand.at(block.ran_ns, work, u_s - v_s, judged=self.judged)
        self.known_ns = block.ran_ns
