# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Where a simulated session writes its traces while it runs, and how one run is taken out of a
batch.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_core.numeric import Array, Value
from pmwvc_core.simulation.agenda import Loop
from pmwvc_core.simulation.traces import (
    Integers,
    ServerTraces,
    UserTraces,
)

SIGNALS = ("x_m", "xd_m", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")
ENERGIES = ("u_m", "u_tx", "v_rx", "v_m", "device", "hand")
PER_USER = ("x_s", "xd_s", "f_s", "u_s", "v_s")


class UserBuffer:
    """Traces of one user: ``(tick, runs, dof)`` while running, so that a tick writes one block of
    memory.
    """

    def __init__(self, name: str, loop: Loop, *, ticks: int, runs: int, dof: int) -> None:
        self.name = name
        self._loop = loop
        every = np.arange(ticks, dtype=np.int64)
        ran = every >= loop.first
        if loop.ran_ns is not None:
            ran &= loop.ran_ns[:ticks] >= 0
        self._ran = every[ran]
        self._block_of = (every - loop.first) // loop.rate_drop
        self._ends = np.zeros(ticks, dtype=np.bool_)
        self._ends[self._ran[np.diff(self._block_of[ran], append=-1) != 0]] = True
        self._last: list[bool] = self._ends.tolist()
        blocks = int(self._ends.sum())
        self.signals = {signal: np.zeros((ticks, runs, dof)) for signal in SIGNALS}
        self.energy = {energy: np.zeros((blocks, runs, 1)) for energy in ENERGIES}
        self.state = np.zeros((blocks, runs, 1), dtype=np.int64)
        self.reason: list[list[str]] = []
        self.accounts: dict[str, Array] = {}

    def write_tick(self, tick: int, **signals: Value) -> None:
        """Write one tick."""
        for name, value in signals.items():
            self.signals[name][tick] = value

    def ends_block(self, tick: int) -> bool:
        """Tell whether a tick is the last one of its frame that the loop ran."""
        return self._last[tick]

    def write_block(
        self,
        state: int | Integers,
        reason: str | Sequence[str],
        accounts: Mapping[str, Value],
        **energies: Value,
    ) -> None:
        """Write what is noted once a frame, after its last tick."""
        block = len(self.reason)
        self.state[block] = state
        self.reason.append([reason] if isinstance(reason, str) else list(reason))
        for name, value in energies.items():
            self.energy[name][block] = value
        _put(self.accounts, block, accounts, like=self.energy["hand"])

    def run(self, run: int, *, tick_s: float, safety_events: int) -> UserTraces:
        """Return the traces of one run: of the ticks that the loop ran."""
        loop, ran = self._loop, self._ran
        ticks = len(self._ends)
        ends = np.minimum(
            loop.first + (self._block_of[self._ends] + 1) * loop.rate_drop, ticks
        ).astype(np.float64)
        time_s = ran.astype(np.float64) * tick_s
        late_s = np.zeros(len(ran))
        if loop.ran_ns is not None:
            late_s = loop.ran_ns[ran].astype(np.float64) * 1e-9 - time_s
        signals: dict[str, Any] = {name: a[ran, run] for name, a in self.signals.items()}
        return UserTraces(
            name=self.name,
            tick_s=tick_s,
            time_s=time_s,
            tick=ran - loop.first,
            lateness_s=late_s,
            compute_s=np.zeros(len(ran)),
            block_time_s=ends * tick_s,
            state=self.state[:, run, 0].copy(),
            reason=[names[run if len(names) > 1 else 0] for names in self.reason],
            energy={name: a[:, run, 0].copy() for name, a in self.energy.items()},
            accounts={name: a[:, run, 0].copy() for name, a in self.accounts.items()},
            missed=int(ran[-1]) - int(ran[0]) + 1 - len(ran) if len(ran) else 0,
            safety_events=safety_events,
            **signals,
        )


class ServerBuffer:
    """Traces of the server: ``(step, runs, dof)``, per user where there are several."""

    def __init__(self, users: Sequence[str], *, steps: int, runs: int, dof: int) -> None:
        self.users = list(users)
        self.object = {name: np.zeros((steps, runs, dof)) for name in ("x_o", "xd_o", "target")}
        self.each = {name: [np.zeros((steps, runs, dof)) for _ in users] for name in PER_USER}
        self.energy = {
            name: [np.zeros((steps, runs, 1)) for _ in users]
            for name in ("energy_u_s", "energy_v_s")
        }
        self.contact = [np.zeros((steps, runs, 1), dtype=np.bool_) for _ in users]
        self.state = [np.zeros(steps, dtype=np.int64) for _ in users]
        self.stored = {
            name: np.zeros((steps, runs, 1)) for name in ("kinetic", "potential", "dissipated")
        }
        self.accounts: dict[str, Array] = {}

    def write(self, step: int, server: Any, presence: Sequence[int], target: float) -> None:
        """Write one step of the environment."""
        self.object["x_o"][step] = server.x_o
        self.object["xd_o"][step] = server.xd_o
        self.object["target"][step, :, 0] = target
        for name, arrays in (*self.each.items(), *self.energy.items()):
            for array, value in zip(arrays, getattr(server, name), strict=True):
                array[step] = value
        for touching, value in zip(self.contact, server.contact, strict=True):
            touching[step] = value
        for states, now in zip(self.state, presence, strict=True):
            states[step] = now
        for name, array in self.stored.items():
            array[step] = getattr(server, name)
        _put(self.accounts, step, server.accounts, like=self.stored["kinetic"])

    def run(self, run: int, *, period_s: float) -> ServerTraces:
        """Return the traces of one run."""
        numbers = np.arange(len(self.object["x_o"]), dtype=np.int64)

        def of(arrays: list[Array], axis: int | slice = slice(None)) -> list[Array]:
            return [array[:, run, axis].copy() for array in arrays]

        parts: dict[str, Any] = {name: a[:, run].copy() for name, a in self.object.items()}
        parts |= {name: of(arrays) for name, arrays in self.each.items()}
        parts |= {name: of(arrays, 0) for name, arrays in self.energy.items()}
        parts |= {name: a[:, run, 0].copy() for name, a in self.stored.items()}
        contact: list[NDArray[np.bool_]] = [array[:, run, 0].copy() for array in self.contact]
        return ServerTraces(
            users=self.users,
            period_s=period_s,
            time_s=numbers.astype(np.float64) * period_s,
            step=numbers + 1,
            contact=contact,
            state=[array.copy() for array in self.state],
            accounts={name: a[:, run, 0].copy() for name, a in self.accounts.items()},
            **parts,
        )


def _put(store: dict[str, Array], row: int, values: Mapping[str, Value], *, like: Array) -> None:
    """Write a row of energies whose names are known only once they come."""
    for name, value in values.items():
        store.setdefault(name, np.zeros_like(like))[row] = value
