# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A loop of ends that are known by themselves, and of links that shift what is sent there.

With z the states of all ends, w what comes in, u what is sent, f the hands' forces held over every
tick and y motion and force at the start of every tick, lifted over a hyperperiod::

    (z(n+1), u(n), y(n)) = M (z(n), w(n), f(n)),      w_j(n) = u_i(n - delay_j)

A packet that comes in within the hyperperiod in which it was sent is put in (``delay_j = 0``); it
was sent before, so there is no algebraic loop. All others are a delay, or states of their own.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.models.ends import Slot
from pmwvc_analysis.models.linear import axes_of
from pmwvc_analysis.models.links import LinkTimes, hyperperiod_ticks, link_times
from pmwvc_analysis.models.matrices import matrices
from pmwvc_analysis.models.response import EndMatrix
from pmwvc_core.numeric import Array, Complex, Integers
from pmwvc_core.scenario.scenario import Scenario


class LinearLoop(NamedTuple):
    """Loops of several runs, ``matrix (runs, states sent read, states came forces)``."""

    scenario: Scenario  # of the first run
    live: bool
    ticks: int  # of the hyperperiod
    dof: int
    states: list[str]
    sent: int  # numbers of all packets of a hyperperiod
    matrix: Array
    sources: Integers  # of everything that comes in, the number of what is sent
    delays: Integers  # [hyperperiods]

    @property
    def tick_s(self) -> float:
        """Period of every force loop [s]."""
        return self.scenario.tick_s

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


def loop_of(*runs: Scenario, live: bool = False, outputs: bool = False) -> LinearLoop:
    """Return the loop of scenarios that differ in what is :func:`.variation.stackable`; ``live``
    takes the phases of a live session instead of the simulator's. NonlinearError if something is
    not linear, PmwvcError if the hyperperiod is too long.

    Packets of the same hyperperiod are put in: w = (I - P D)^-1 P (C z + ...), with P D nilpotent.
    """
    scenario, (parts, which) = runs[0], zip(*matrices(runs, live, outputs), strict=True)
    times = [link_times(user, scenario, live=live) for user in scenario.users]
    ticks, (states, matrix) = hyperperiod_ticks(scenario), _joined(parts, which)
    sources, delays = _wires(parts, times, ticks)
    n, used = len(states), len(states) + np.arange(len(sources))
    counts = matrix[:, :, used].any(axis=(0, 1))  # what of the packets is read
    now, late = np.flatnonzero(counts & (delays == 0)), np.flatnonzero(counts & (delays > 0))
    left = np.r_[:n, n + late, n + len(sources) : matrix.shape[2]]
    rows = matrix[:, n + sources[now]]
    came = np.linalg.solve(np.eye(len(now)) - rows[:, :, n + now], rows[:, :, left])
    matrix = matrix[:, :, left] + matrix[:, :, n + now] @ came
    sent = sum(len(part.sent) for part in parts)
    wires = sources[late], delays[late]
    return LinearLoop(scenario, live, ticks, axes_of(scenario), states, sent, matrix, *wires)


def held(loop: LinearLoop) -> tuple[list[str], Array]:
    """Return the states of a loop with every packet under way as one, one for each hyperperiod,
    and its matrix ``(runs, states sent read, states forces)``.
    """
    n, delays = len(loop.states), loop.delays
    first = np.cumsum(delays) - delays  # of the packets of each wire
    m, came = int(delays.sum()), slice(n, n + len(delays))
    passed = np.zeros((*loop.matrix.shape[:2], m))
    passed[:, :, first + delays - 1] = loop.matrix[:, :, came]
    ends = loop.matrix[:, :, :n], passed, loop.matrix[:, :, came.stop :]
    whole = np.concatenate(ends, axis=2)
    packets = np.zeros((len(whole), m, whole.shape[2]))
    packets[:, first] = whole[:, n + loop.sources]
    later = np.setdiff1d(np.arange(m), first)
    packets[:, later, n + later - 1] = 1.0
    names = [f"packet under way {k}" for k in range(1, m + 1)]
    return loop.states + names, np.concatenate([whole[:, :n], packets, whole[:, n:]], axis=1)


def _joined(parts: Sequence[EndMatrix], which: Sequence[Integers]) -> tuple[list[str], Array]:
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
) -> tuple[Integers, Integers]:
    """Return for everything that comes in the number of what is sent, and how many hyperperiods
    ago.
    """
    *users, server = parts
    firsts = np.cumsum([0, *(len(each.sent) for each in users)])
    up = [each.up.wires(ticks) for each in times]
    down = [each.down.wires(ticks) for each in times]
    at_server = {signal: firsts[-1] + at for at, signal in enumerate(server.sent)}
    found = []
    for i, end in enumerate(users):
        for slot, number in end.came:
            sent, ago = down[i][slot.packet]
            found.append((at_server[Slot(i, sent), number], ago))
    for slot, number in server.came:
        sent, ago = up[slot.way][slot.packet]
        at = users[slot.way].sent.index((Slot(0, sent), number))
        found.append((firsts[slot.way] + at, ago))
    return tuple(np.array(found).T)
