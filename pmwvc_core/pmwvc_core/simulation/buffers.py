# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Buffers of a simulated session's traces."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from pmwvc_core.frame.rows import SIGNALS, FrameReport, ServerRow
from pmwvc_core.numeric import Array, Integers, Value
from pmwvc_core.simulation.columns import Accounts, Columns
from pmwvc_core.simulation.ticks import Frame
from pmwvc_core.traces import ENERGIES, OF_AVATARS, ServerTraces, SessionTraces, UserTraces

STATE = "state"  # a small whole number, kept beside the energies
OBJECT = ("x_o", "xd_o")
STORED = ("kinetic", "potential", "dissipated")
ENERGIES_PER_USER = ("energy_u_s", "energy_v_s")


class UserBuffer:
    """Traces of one user while running: rows per tick, and per frame after its last tick.

    Parameters
    ----------
    ticks, blocks
        Of the session; frames at most.
    """

    def __init__(self, name: str, *, ticks: int, blocks: int, dof: int) -> None:
        self.name = name
        self._every = ticks
        self._ticks: list[int] = []  # that ran, and when [ns]
        self._times_ns: list[int] = []
        self._ends: list[int] = []  # of frames [ticks]
        self._changes: list[int] = []
        self._signals = Columns(SIGNALS, rows=ticks, width=dof)
        names = (*ENERGIES, STATE)
        self._energies = Columns(names, rows=blocks, width=1)
        self._reason: list[str] = []
        self._accounts = Accounts(rows=blocks)

    @property
    def times_ns(self) -> Sequence[int]:
        """When the ticks ran [ns]."""
        return self._times_ns

    @cached_property
    def _ran(self) -> tuple[Integers, Integers]:
        """Ticks that ran and when [ns], once all have."""
        times_ns = np.array(self._times_ns, dtype=np.int64)
        return np.array(self._ticks, dtype=np.int64), times_ns

    def write_ticks(self, frame: Frame) -> None:
        """Write the signals of consecutive ticks."""
        self._signals.write(frame.ticks, frame.values)
        self._ticks += frame.ticks
        self._times_ns += frame.times_ns

    def write_block(
        self, ends: int, report: FrameReport, work: tuple[Value, Value], *, changes: int
    ) -> None:
        """Write the report of a frame that ends with a tick, with the work at the device [J] and
        how many frames have taken changes over.
        """
        block = len(self._ends)
        reason = report.reason
        self._ends.append(min(ends, self._every))
        self._changes.append(changes)
        self._reason.append(str(reason))
        energies = (report.u_m, report.u_tx, report.v_rx, report.v_m, *work, report.state)
        self._energies.write((block,), energies)
        if report.accounts:
            self._accounts.write(block, report.accounts)

    def traces(self, *, first: int, tick_s: float, safety_events: int) -> UserTraces:
        """Return the traces of the ticks that ran, numbered from the first."""
        ran, times_ns = self._ran
        late_ns = times_ns - ran * round(tick_s * 1e9)
        signals: dict[str, Any] = {name: self._signals.of(name) for name in SIGNALS}
        for name, rows in signals.items():  # an index for every row takes much longer than a copy
            signals[name] = rows.copy() if len(ran) == self._every else rows[ran]
        blocks = len(self._ends)
        energies = {name: self._energies.of(name)[:blocks, 0].copy() for name in ENERGIES}
        return UserTraces(
            name=self.name,
            tick_s=tick_s,
            time_s=ran.astype(np.float64) * tick_s,
            tick=ran - first,
            lateness_s=late_ns.astype(np.float64) * 1e-9,
            compute_s=np.zeros(len(ran)),
            block_time_s=np.array(self._ends, dtype=np.float64) * tick_s,
            state=self._energies.of(STATE)[:blocks, 0].astype(np.int64),
            reason=self._reason,
            energy=energies,
            accounts=self._accounts.of(blocks),
            changes=np.array(self._changes, dtype=np.int64),
            looked_ns=late_ns,
            missed=int(ran[-1]) - int(ran[0]) + 1 - len(ran) if len(ran) else 0,
            safety_events=safety_events,
            **signals,
        )


class ServerBuffer:
    """Traces of the server while running: a row per step.

    Attributes
    ----------
    ticks, ran_ns, periods_s
        Of each step: its tick, when it ran [ns], how long it lasted [s].
    """

    def __init__(self, users: Sequence[str], *, steps: int, dof: int) -> None:
        self.users = list(users)
        signals = _names(OBJECT, OF_AVATARS, users)
        energies = _names(STORED, (*ENERGIES_PER_USER, "contact"), users)
        self._signals = Columns(signals, rows=steps, width=dof)
        self._energies = Columns(energies, rows=steps, width=1)
        self._state: list[tuple[int, ...]] = []
        self._target: list[Value] = []
        self._accounts = Accounts(rows=steps)
        self.ticks: list[int] = []
        self.ran_ns: list[int] = []
        self.periods_s: list[float] = []
        self.changes: list[int] = []

    def write(
        self, tick: int, ran_ns: int, period_s: float, row: ServerRow, *, changes: int
    ) -> None:
        """Write one step of the server, with how many have taken changes over."""
        step = len(self.ticks)
        self.changes.append(changes)
        self.ticks.append(tick)
        self.ran_ns.append(ran_ns)
        self.periods_s.append(period_s)
        signals = [row.x_o, row.xd_o]
        energies: list[Value] = [row.kinetic, row.potential, row.dissipated]
        for port in row.ports:
            signals += port[:5]
            energies += (port.energy_u_s, port.energy_v_s, float(port.contact))
        self._signals.write((step,), signals)
        self._energies.write((step,), energies)
        self._state.append(row.state)
        self._target.append(row.target)
        if row.accounts:
            self._accounts.write(step, row.accounts)

    def traces(self, *, time_s: Array, tick_ns: int) -> ServerTraces:
        """Return the traces, given when steps began [s]."""
        steps, each = len(self.ticks), range(len(self.users))

        def of(columns: Columns, name: str) -> Array:
            return columns.of(name)[:steps].copy()

        parts: dict[str, Any] = {name: of(self._signals, name) for name in OBJECT}
        parts["target"] = np.array(self._target).reshape(parts["x_o"].shape)
        for name in OF_AVATARS:
            parts[name] = [of(self._signals, f"{name}{i}") for i in each]
        for name in STORED:
            parts[name] = of(self._energies, name)[:, 0]
        for name in ENERGIES_PER_USER:
            parts[name] = [of(self._energies, f"{name}{i}")[:, 0] for i in each]
        return ServerTraces(
            users=self.users,
            periods_s=np.array(self.periods_s, dtype=np.float64),
            time_s=time_s,
            step=np.arange(1, steps + 1, dtype=np.int64),
            contact=[of(self._energies, f"contact{i}")[:, 0] != 0.0 for i in each],
            state=[column.copy() for column in self._presence.T],
            accounts=self._accounts.of(steps),
            changes=np.array(self.changes, dtype=np.int64),
            looked_ns=np.array(self.ran_ns, dtype=np.int64) - np.array(self.ticks) * tick_ns,
            **parts,
        )

    @cached_property
    def _presence(self) -> Integers:
        """State of each user after each step, once all have run: the same in every run."""
        state = np.array(self._state, dtype=np.int64)
        return state.reshape(len(self.ticks), len(self.users))


def _names(common: Sequence[str], each: Sequence[str], users: Sequence[str]) -> list[str]:
    """Return names of columns: those per user with its number behind."""
    return [*common, *(f"{name}{i}" for i in range(len(users)) for name in each)]


def add_learned(traces: SessionTraces, user: str, ratio: float) -> None:
    """Add what a server's port learned of a contact, (K T + 2B)/b, where that is above 1."""
    if ratio > 1.0:
        what = f"its server port learned K T + 2B = {ratio:.3g} b"
        event = {"time_s": None, "who": user, "kind": "environment", "what": what}
        traces.events.append(event)


def add_faults(traces: SessionTraces, server: Any) -> None:
    """Add how often an environment, or the solution of a step, failed, and why at last."""
    faults = server.faults
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
