# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of both loops, as MasterTrace and ServerTrace messages."""

from array import array
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_core.numeric import Value
from pmwvc_core.runtime.messages.types import MessageTypes, axes, scalar, time_message

_PER_AXIS = ("x", "xd", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")


class TraceBlock:
    """The ticks of one trace message, written one after the other into arrays made once.

    Parameters
    ----------
    ticks
        Most ticks a block holds.
    dof
        Values per tick of everything but ``lateness`` and ``compute``.
    """

    def __init__(self, ticks: int, dof: int) -> None:
        self.ticks = ticks
        self.dof = dof
        self.count = 0
        self._series = {name: array("d", bytes(8 * ticks * dof)) for name in _PER_AXIS}
        self._series |= {name: array("f", bytes(4 * ticks)) for name in ("lateness", "compute")}
        self._columns = tuple(self._series[name] for name in _PER_AXIS)
        self._rows = tuple(np.frombuffer(c).reshape(ticks, dof) for c in self._columns)
        self._lateness, self._compute = self._series["lateness"], self._series["compute"]

    @property
    def full(self) -> bool:
        """Tell whether the block has to be sent before the next tick."""
        return self.count == self.ticks

    def put(
        self,
        x: Value,
        xd: Value,
        f_h: Value,
        f_m: Value,
        f_applied: Value,
        u_m: Value,
        u_m_lp: Value,
        v_m: Value,
        lateness: float,
        compute: float,
    ) -> None:
        """Write one tick (SI units; ``lateness`` and ``compute`` in s)."""
        k = self.count
        if self.dof == 1:
            a, b, c, d, e, f, g, h = self._columns
            a[k], b[k], c[k], d[k] = x, xd, f_h, f_m  # type: ignore[assignment]
            e[k], f[k], g[k], h[k] = f_applied, u_m, u_m_lp, v_m  # type: ignore[assignment]
        else:
            values = (x, xd, f_h, f_m, f_applied, u_m, u_m_lp, v_m)
            for row, value in zip(self._rows, values, strict=True):
                row[k] = value
        self._lateness[k] = lateness
        self._compute[k] = compute
        self.count = k + 1

    def series(self) -> Mapping[str, "array[float]"]:
        """Return what was written by field name; valid until the next ``put``."""
        if self.full:
            return self._series
        count, values = self.count, self.count * self.dof
        return {n: a[: values if n in _PER_AXIS else count] for n, a in self._series.items()}

    def clear(self) -> None:
        """Start the next block."""
        self.count = 0


def master_trace(
    types: MessageTypes,
    series: Mapping[str, Any],
    *,
    stamp_ns: int,
    start_ns: int,
    epoch: int,
    seq: int,
    first_tick: int,
    period: float,
    dof: int,
    state: int,
    reason: str,
    missed: int,
    safety_events: int,
    hand_force_known: bool,
    energy: Mapping[str, Value],
    accounts: Mapping[str, Value],
) -> Any:
    """Return one block of ticks as a MasterTrace message.

    Parameters
    ----------
    series
        Per-tick fields by name, row-major: ``TraceBlock.series()``, or arrays.
    energy
        ``u_m, u_tx, v_rx, v_m, device, hand`` [J] at the end of the block.
    accounts
        Energies that only this controller keeps [J].
    """
    numbers = {n: types.sequence(series[n], "d") for n in _PER_AXIS}
    numbers |= {n: types.sequence(series[n], "f") for n in ("lateness", "compute")}
    return types.MasterTrace(
        stamp=time_message(types, stamp_ns),
        start_ns=start_ns,
        epoch=epoch,
        seq=seq,
        first_tick=first_tick,
        period=period,
        dof=dof,
        state=int(state),
        reason=reason,
        missed=missed,
        safety_events=safety_events,
        hand_force_known=hand_force_known,
        energy_u_m=scalar(energy["u_m"]),
        energy_u_tx=scalar(energy["u_tx"]),
        energy_v_rx=scalar(energy["v_rx"]),
        energy_v_m=scalar(energy["v_m"]),
        energy_device=scalar(energy["device"]),
        energy_hand=scalar(energy["hand"]),
        account_names=list(accounts),
        accounts=types.sequence([scalar(entry) for entry in accounts.values()], "d"),
        **numbers,
    )


def server_trace(
    types: MessageTypes,
    *,
    stamp_ns: int,
    start_ns: int,
    epoch: int,
    step: int,
    period: float,
    dof: int,
    users: Sequence[str],
    x_o: Value,
    xd_o: Value,
    target: Value,
    x_s: Sequence[Value],
    xd_s: Sequence[Value],
    f_s: Sequence[Value],
    u_s: Sequence[Value],
    v_s: Sequence[Value],
    state: Sequence[int],
    contact: Sequence[bool],
    energy_u_s: Sequence[Value],
    energy_v_s: Sequence[Value],
    kinetic: Value,
    potential: Value,
    dissipated: Value,
    accounts: Mapping[str, Value],
    lateness: float = 0.0,
    compute: float = 0.0,
) -> Any:
    """Return one step of the server as a ServerTrace; one entry a user in every sequence."""

    def each(*values: Value) -> Any:
        return types.sequence([entry for value in values for entry in axes(value, dof)], "d")

    return types.ServerTrace(
        stamp=time_message(types, stamp_ns),
        start_ns=start_ns,
        epoch=epoch,
        step=step,
        period=period,
        dof=dof,
        users=list(users),
        x_o=each(x_o),
        xd_o=each(xd_o),
        target=each(target),
        x_s=each(*x_s),
        xd_s=each(*xd_s),
        f_s=each(*f_s),
        u_s=each(*u_s),
        v_s=each(*v_s),
        state=types.sequence([int(entry) for entry in state], "B"),
        contact=types.flags(contact),
        energy_u_s=types.sequence([scalar(entry) for entry in energy_u_s], "d"),
        energy_v_s=types.sequence([scalar(entry) for entry in energy_v_s], "d"),
        kinetic=scalar(kinetic),
        potential=scalar(potential),
        dissipated=scalar(dissipated),
        account_names=list(accounts),
        accounts=types.sequence([scalar(entry) for entry in accounts.values()], "d"),
        lateness=lateness,
        compute=compute,
    )
