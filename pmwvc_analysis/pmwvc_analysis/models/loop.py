# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A loop of ends that are known by themselves, and of links that shift what is sent there.

With z the states of all ends, w what comes in, u what is sent, f the hands' forces held over every
tick and y motion and force at the start of every tick, lifted over a hyperperiod::

    (z(n+1), u(n), y(n)) = M (z(n), w(n), f(n)),      w_j(n) = u_i(n - delay_j)

A packet that comes in within the hyperperiod in which it was sent is put in (``delay_j = 0``); it
was sent before, so there is no algebraic loop. Packets on longer ways are states of their own, or
a delay, whatever its length.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.models.ends import Slot
from pmwvc_analysis.models.linear import axes_of
from pmwvc_analysis.models.links import LinkTimes, hyperperiod_ticks, link_times
from pmwvc_analysis.models.matrices import matrices
from pmwvc_analysis.models.response import EndMatrix, Signal, StateName
from pmwvc_core.numeric import Array, Complex, Flags, Integers
from pmwvc_core.scenario.scenario import Scenario


class LinearLoop(NamedTuple):
    """Loops of several runs, ``matrix (runs, states sent read, states came forces)``."""

    scenario: Scenario  # of the first run
    live: bool
    ticks: int  # of the hyperperiod
    dof: int
    states: list[StateName]
    sent: int  # numbers of all packets of a hyperperiod
    matrix: Array
    sources: Integers  # of everything that comes in, the number of what is sent
    delays: Integers  # [hyperperiods]
    ways: Integers  # numbers of users from 1 on; on the way down below zero

    @property
    def tick_s(self) -> float:
        """Period of every force loop [s]."""
        return self.scenario.tick_s

    @property
    def came(self) -> Integers:
        """Columns of what comes in."""
        return np.asarray(len(self.states) + np.arange(len(self.sources)))

    @property
    def system(self) -> tuple[Array, Array]:
        """The first run's rows for states and what comes in, and for what is read, by states, what
        comes in and forces.
        """
        n, whole = len(self.states), self.matrix[0]
        return np.concatenate([whole[:n], whole[n + self.sources]]), whole[n + self.sent :]

    def equations(self, z: Complex) -> Complex:
        """Return [zI - A, -B; -C, z^delay I - D] of the first run at points of the z-plane
        ``(points, n, n)``, for states and what comes in.
        """
        rows, _ = self.system
        delays = np.r_[np.ones(len(self.states), dtype=np.int64), self.delays]
        turned = (z[:, np.newaxis] ** delays)[:, :, np.newaxis]
        return np.asarray(turned * np.eye(len(rows)) - rows[:, : len(rows)])


class System(NamedTuple):
    """A linear system with n states, [A, B; C, D]."""

    matrix: Array
    n: int

    def poles(self) -> Complex:
        """Return the eigenvalues of A."""
        return np.asarray(np.linalg.eigvals(self.matrix[: self.n, : self.n]).astype(complex))

    @property
    def growth(self) -> float:
        """The length of the longest eigenvalue of A; 0 without a state."""
        return float(np.abs(self.poles()).max(initial=0.0))

    def angles_near(self, width: Array, widths: Array) -> Array:
        """Return angles so many widths [rad] before and behind that of every pole."""
        steps = np.multiply.outer(width, np.concatenate([-widths, widths]))
        return np.ravel(np.abs(np.angle(self.poles()))[:, np.newaxis] + steps)

    def response(self, z: Complex) -> Complex:
        """Return what goes out per what comes in ``(points, outputs, inputs)`` at points of the
        z-plane.
        """
        n, whole = self.n, self.matrix
        resolvent = z[:, np.newaxis, np.newaxis] * np.eye(n) - whole[:n, :n]
        driven = np.linalg.solve(resolvent, whole[:n, n:].astype(np.complex128))
        return np.asarray(whole[n:, :n] @ driven + whole[n:, n:])


def loop_of(*runs: Scenario, live: bool = False, outputs: bool = False) -> LinearLoop:
    """Return the loop of scenarios that differ in what is :func:`.variation.stackable`; ``live``
    takes the phases of a live session instead of the simulator's. NonlinearError if something is
    not linear, PmwvcError if the hyperperiod is too long.
    """
    scenario = runs[0]
    parts, which = zip(*matrices(runs, live, outputs), strict=True)
    times = [link_times(user, scenario, live=live) for user in scenario.users]
    ticks, (states, matrix) = hyperperiod_ticks(scenario), _joined(parts, which)
    sources, delays, ways = _wires(parts, times, ticks)
    n, used = len(states), len(states) + np.arange(len(sources))
    read = np.flatnonzero(matrix[:, :, used].any(axis=(0, 1)))  # what of the packets counts
    kept = np.r_[:n, n + read, n + len(sources) : matrix.shape[2]]
    wires = sources[read], delays[read], ways[read]
    dof = axes_of(scenario)
    sent = sum(len(part.sent) for part in parts)
    return LinearLoop(scenario, live, ticks, dof, states, sent, matrix[:, :, kept], *wires)


def put_in(loop: LinearLoop) -> LinearLoop:
    """Return a loop in which packets of the same hyperperiod no longer come in: w = (I - P D)^-1 P
    (C z + ...), with P D nilpotent.
    """
    n, now = len(loop.states), loop.delays == 0
    rows = loop.matrix[:, n + loop.sources[now]]
    left = np.setdiff1d(np.arange(loop.matrix.shape[2]), loop.came[now])
    ahead = np.eye(int(np.sum(now))) - rows[:, :, loop.came[now]]
    came = np.linalg.solve(ahead, rows[:, :, left])
    matrix = loop.matrix[:, :, left] + loop.matrix[:, :, loop.came[now]] @ came
    return _with_wires(loop._replace(matrix=matrix), ~now)


def held(loop: LinearLoop, which: Flags) -> LinearLoop:
    """Return a loop with the packets of some wires as states, one for each hyperperiod."""
    n, delays, came = len(loop.states), loop.delays[which], loop.came[which]
    first = np.cumsum(delays) - delays  # of the packets of each wire
    m = int(delays.sum())
    passed = np.zeros((*loop.matrix.shape[:2], m))
    passed[:, :, first + delays - 1] = loop.matrix[:, :, came]
    others = np.delete(loop.matrix, came, axis=2)
    whole = np.concatenate([others[:, :, :n], passed, others[:, :, n:]], axis=2)
    packets = np.zeros((len(whole), m, whole.shape[2]))
    packets[:, first] = whole[:, n + loop.sources[which]]
    later = np.setdiff1d(np.arange(m), first)
    packets[:, later, n + later - 1] = 1.0
    whole = np.concatenate([whole[:, :n], packets, whole[:, n:]], axis=1)
    names = [(f"packet under way {k}", 0) for k in range(1, m + 1)]
    return _with_wires(loop._replace(states=loop.states + names, matrix=whole), ~which)


def _with_wires(loop: LinearLoop, which: Flags) -> LinearLoop:
    kept = loop.sources[which], loop.delays[which], loop.ways[which]
    return loop._replace(sources=kept[0], delays=kept[1], ways=kept[2])


def _joined(
    parts: Sequence[EndMatrix], which: Sequence[Integers]
) -> tuple[list[StateName], Array]:
    """Return the ends as one, with all states, all packets and all forces in a row."""
    kinds, of_rows, of_columns = np.arange(3), list[Integers](), list[Integers]()
    sizes = np.array([each.matrix.shape[1:] for each in parts])
    whole = np.zeros((len(which[0]), *sizes.sum(axis=0)))
    for part, runs, (row, column) in zip(
        parts, which, np.cumsum(sizes, axis=0) - sizes, strict=True
    ):
        n, came, sent = len(part.states), len(part.came), len(part.sent)
        height, width = part.matrix.shape[1:]
        whole[:, row : row + height, column : column + width] = part.matrix[runs]
        of_rows.append(np.repeat(kinds, [n, sent, part.read]))
        of_columns.append(np.repeat(kinds, [n, came, width - n - came]))
    rows, columns = (np.argsort(np.concatenate(of), kind="stable") for of in (of_rows, of_columns))
    return [name for each in parts for name in each.states], whole[:, rows][:, :, columns]


def _wires(
    parts: Sequence[EndMatrix], times: Sequence[LinkTimes], ticks: int
) -> tuple[Integers, Integers, Integers]:
    """Return for everything that comes in the number of what is sent, how many hyperperiods ago,
    and whose way it is: numbers of users from 1 on, on the way down below zero.
    """
    *users, server = parts
    firsts = np.cumsum([0, *(len(each.sent) for each in users)])
    up = [each.up.wires(ticks) for each in times]
    down = [each.down.wires(ticks) for each in times]
    at_server = {signal: firsts[-1] + at for at, signal in enumerate(server.sent)}
    found = []
    for i, end in enumerate(users):
        for slot, name, axis in end.came:
            sent, ago = down[i][slot.packet]
            found.append((at_server[Signal(Slot(i, sent), name, axis)], ago, -1 - i))
    for slot, name, axis in server.came:
        sent, ago = up[slot.way][slot.packet]
        at = users[slot.way].sent.index(Signal(Slot(0, sent), name, axis))
        found.append((firsts[slot.way] + at, ago, 1 + slot.way))
    return tuple(np.array(found).T)
