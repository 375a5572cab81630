# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Buffers of a simulated session's traces, and the traces of one run of a batch."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_core.frame.force_loop import SIGNALS, FrameReport
from pmwvc_core.frame.server_step import ServerRow, ServerStep
from pmwvc_core.numeric import Array, Value, where
from pmwvc_core.simulation.columns import Columns
from pmwvc_core.simulation.event_schedule import LoopTimes
from pmwvc_core.traces import ServerTraces, SessionTraces, UserTraces

ENERGIES = ("u_m", "u_tx", "v_rx", "v_m", "device", "hand")
OBJECT = ("x_o", "xd_o")
PER_USER = ("x_s", "xd_s", "f_s", "u_s", "v_s")
STORED = ("kinetic", "potential", "dissipated")
ENERGIES_PER_USER = ("energy_u_s", "energy_v_s")


class UserBuffer:
    """Traces of one user while running: rows per tick, and per frame after its last tick."""

    def __init__(self, name: str, loop: LoopTimes, *, ticks: int, runs: int, dof: int) -> None:
        self.name = name
        self._loop = loop
        every = np.arange(ticks, dtype=np.int64)
        ran = every >= loop.first
        if loop.ran_ns is not None:
            ran &= loop.ran_ns[:ticks] >= 0
        self._ran = every[ran]
        self._starts = loop.starts(ticks)
        self._block_of = np.searchsorted(self._starts, every, side="right") - 1
        self._ends = np.zeros(ticks, dtype=np.bool_)
        self._ends[self._ran[np.diff(self._block_of[ran], append=-1) != 0]] = True
        self._last = frozenset(np.flatnonzero(self._ends).tolist())
        blocks = len(self._last)
        plain = runs == dof == 1
        self._signals = Columns(SIGNALS, rows=ticks, runs=runs, width=dof, plain=plain)
        self._energies = Columns(ENERGIES, rows=blocks, runs=runs, width=1, plain=plain)
        self._state = np.zeros((blocks, runs, 1), dtype=np.int64)
        self._reason: list[list[str]] = []
        self._accounts: dict[str, Array] = {}

    def write_ticks(self, ticks: Sequence[int], values: Sequence[Value]) -> None:
        """Write ``SIGNALS`` of consecutive ticks, tick by tick."""
        self._signals.write(ticks, values)

    def ends_block(self, tick: int) -> bool:
        """Tell whether a tick is the last one of its frame that the loop ran."""
        return tick in self._last

    def write_block(self, report: FrameReport, work: tuple[Value, Value]) -> None:
        """Write the report of a frame, after its last tick, with the work at the device [J]."""
        block = len(self._reason)
        reason = report.reason
        self._state[block] = report.state
        self._reason.append([reason] if isinstance(reason, str) else list(reason))
        energies = (report.u_m, report.u_tx, report.v_rx, report.v_m, *work)
        self._energies.write([block], energies)
        if report.accounts:
            _put(self._accounts, block, report.accounts, shape=self._state.shape)

    def run(self, run: int, *, tick_s: float, safety_events: int) -> UserTraces:
        """Return the traces of one run: of the ticks that the loop ran."""
        loop, ran = self._loop, self._ran
        ticks = len(self._ends)
        ends = np.minimum(self._starts[self._block_of[self._ends] + 1], ticks).astype(np.float64)
        time_s = ran.astype(np.float64) * tick_s
        late_s = np.zeros(len(ran))
        if loop.ran_ns is not None:
            late_s = loop.ran_ns[ran].astype(np.float64) * 1e-9 - time_s
        signals: dict[str, Any] = {name: self._signals.of(name, run) for name in SIGNALS}
        for name, rows in signals.items():  # an index for every row takes much longer than a copy
            signals[name] = rows.copy() if len(ran) == ticks else rows[ran]
        return UserTraces(
            name=self.name,
            tick_s=tick_s,
            time_s=time_s,
            tick=ran - loop.first,
            lateness_s=late_s,
            compute_s=np.zeros(len(ran)),
            block_time_s=ends * tick_s,
            state=self._state[:, run, 0].copy(),
            reason=[names[run if len(names) > 1 else 0] for names in self._reason],
            energy={name: self._energies.of(name, run)[:, 0].copy() for name in ENERGIES},
            accounts={name: a[:, run, 0].copy() for name, a in self._accounts.items()},
            missed=int(ran[-1]) - int(ran[0]) + 1 - len(ran) if len(ran) else 0,
            safety_events=safety_events,
            **signals,
        )


class ServerBuffer:
    """Traces of the server while running: a row per step."""

    def __init__(self, users: Sequence[str], *, steps: int, runs: int, dof: int) -> None:
        self.users = list(users)
        signals = _names(OBJECT, PER_USER, users)
        energies = _names(STORED, (*ENERGIES_PER_USER, "contact"), users)
        plain = runs == dof == 1
        self._signals = Columns(signals, rows=steps, runs=runs, width=dof, plain=plain)
        self._energies = Columns(energies, rows=steps, runs=runs, width=1, plain=plain)
        self._state: list[tuple[int, ...]] = []
        self._target: list[Value] = []
        self._accounts: dict[str, Array] = {}
        self._shape = (steps, runs, 1)

    def write(self, step: int, row: ServerRow) -> None:
        """Write one step of the server."""
        signals = [row.x_o, row.xd_o]
        energies: list[Value] = [row.kinetic, row.potential, row.dissipated]
        for port in row.ports:
            signals += port[:5]
            energies += (port.energy_u_s, port.energy_v_s, where(port.contact, 1.0, 0.0))
        self._signals.write([step], signals)
        self._energies.write([step], energies)
        self._state.append(row.state)
        self._target.append(row.target)
        if row.accounts:
            _put(self._accounts, step, row.accounts, shape=self._shape)

    def run(self, run: int, *, time_s: Array, periods_s: Array) -> ServerTraces:
        """Return the traces of one run, given when steps began and how long they lasted [s]."""
        numbers = np.arange(len(self._target), dtype=np.int64)
        each = range(len(self.users))
        signals = {name: self._signals.of(name, run).copy() for name in OBJECT}
        parts: dict[str, Any] = dict(signals)
        parts["target"] = np.array(self._target).reshape(signals["x_o"].shape)
        for name in PER_USER:
            parts[name] = [self._signals.of(f"{name}{i}", run).copy() for i in each]
        for name in STORED:
            parts[name] = self._energies.of(name, run)[:, 0].copy()
        for name in ENERGIES_PER_USER:
            parts[name] = [self._energies.of(f"{name}{i}", run)[:, 0].copy() for i in each]
        contact = [self._energies.of(f"contact{i}", run)[:, 0] != 0.0 for i in each]
        state = np.array(self._state, dtype=np.int64).reshape(len(numbers), len(self.users))
        return ServerTraces(
            users=self.users,
            periods_s=periods_s,
            time_s=time_s,
            step=numbers + 1,
            contact=contact,
            state=[column.copy() for column in state.T],
            accounts={name: a[:, run, 0].copy() for name, a in self._accounts.items()},
            **parts,
        )


def _names(common: Sequence[str], each: Sequence[str], users: Sequence[str]) -> list[str]:
    """Return names of columns: those per user with its number behind."""
    return [*common, *(f"{name}{i}" for i in range(len(users)) for name in each)]


def _put(
    store: dict[str, Array], row: int, values: Mapping[str, Value], *, shape: tuple[int, ...]
) -> None:
    """Write a row of energies whose names are known only once they come."""
    for name, value in values.items():
        store.setdefault(name, np.zeros(shape))[row] = value


def add_faults(traces: SessionTraces, server: ServerStep) -> None:
    """Add how often an environment, or the solution of a step, failed, and why at last."""
    faults = server.server.faults
    if faults is None or not faults.steps:
        return
    if faults.replaced:
        traces.metadata[faults.what] = {
            "contained_steps": str(faults.steps),
            "last_fault": faults.text,
        }
        return
    what = f"{faults.steps} steps: {faults.text}"
    traces.events.append({"time_s": None, "who": "server", "kind": "environment", "what": what})
