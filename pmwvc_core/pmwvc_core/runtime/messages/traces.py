# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of both loops, as MasterTrace and ServerTrace messages."""

from array import array
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_core.numeric import Value
from pmwvc_core.runtime.messages.fields import OF_OBJECT, PER_AXIS
from pmwvc_core.runtime.messages.types import MessageTypes, axes, scalar, time_message
from pmwvc_core.traces import ENERGIES, OF_AVATARS
from pmwvc_core.transport.packet import WavePacket

_PER_TICK = {"lateness": "f", "compute": "f", "looked": "I"}
_UINT32 = 0xFFFFFFFF


class TraceBlock:
    """The ticks of one trace message, written one after the other into arrays made once: at most
    ``ticks`` of them, with ``dof`` values of every signal.

    Attributes
    ----------
    taken
        Tick of the block, number and sender's epoch of each packet given to the receiver, in
        their order.
    """

    def __init__(self, ticks: int, dof: int) -> None:
        self.ticks = ticks
        self.dof = dof
        self.count = 0
        self._series = {name: array("d", bytes(8 * ticks * dof)) for name in PER_AXIS}
        self._series |= {name: array(code, bytes(4 * ticks)) for name, code in _PER_TICK.items()}
        self.taken: list[tuple[int, int, int]] = []
        self._columns = tuple(self._series[name] for name in PER_AXIS)
        self._rows = tuple(np.frombuffer(c).reshape(ticks, dof) for c in self._columns)
        self._of_tick = tuple(self._series[name] for name in _PER_TICK)

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
        looked_ns: int,
        packets: Sequence[WavePacket],
    ) -> None:
        """Write one tick: signals, ``lateness`` and ``compute`` [s], when packets were taken in
        after the deadline [ns], and these packets.
        """
        k = self.count
        if self.dof == 1:
            a, b, c, d, e, f, g, h = self._columns
            a[k], b[k], c[k], d[k] = x, xd, f_h, f_m  # type: ignore[assignment]
            e[k], f[k], g[k], h[k] = f_applied, u_m, u_m_lp, v_m  # type: ignore[assignment]
        else:
            values = (x, xd, f_h, f_m, f_applied, u_m, u_m_lp, v_m)
            for row, value in zip(self._rows, values, strict=True):
                row[k] = value
        late, took, looked = self._of_tick
        late[k], took[k], looked[k] = lateness, compute, min(looked_ns, _UINT32)
        if packets:
            self.taken += [(k, each.seq, each.epoch) for each in packets if not each.refusal]
        self.count = k + 1

    def series(self) -> Mapping[str, "array[float]"]:
        """Return what was written by field name; valid until the next ``put``."""
        if self.full:
            return self._series
        count, values = self.count, self.count * self.dof
        return {n: a[: values if n in PER_AXIS else count] for n, a in self._series.items()}

    def clear(self) -> None:
        """Start the next block."""
        self.count = 0
        self.taken.clear()


def master_trace(
    types: MessageTypes,
    series: Mapping[str, Any],
    *,
    taken: Sequence[tuple[int, int, int]],
    stamp_ns: int,
    energy: Mapping[str, Value],
    accounts: Mapping[str, Value],
    **fields: Any,
) -> Any:
    """Return one block of ticks as a MasterTrace message.

    Parameters
    ----------
    series
        Per-tick fields by name, row-major: ``TraceBlock.series()``, or arrays.
    taken
        Tick, number and sender's epoch of each packet taken in.
    energy
        ``u_m, u_tx, v_rx, v_m, device, hand`` [J] at the end of the block.
    accounts
        Energies that only this controller keeps [J].
    fields
        All others, as in ``MasterTrace.msg``.
    """
    return types.MasterTrace(
        stamp=time_message(types, stamp_ns),
        **{name: types.sequence(series[name], "d") for name in PER_AXIS},
        **{name: types.sequence(series[name], code) for name, code in _PER_TICK.items()},
        **_taken(types, "tick", taken),
        **{f"energy_{name}": scalar(energy[name]) for name in ENERGIES},
        **_accounts(types, accounts),
        **fields,
    )


def server_trace(
    types: MessageTypes,
    *,
    stamp_ns: int,
    dof: int,
    state: Sequence[int],
    contact: Sequence[bool],
    taken: Sequence[tuple[int, int, int]],
    accounts: Mapping[str, Value],
    **fields: Any,
) -> Any:
    """Return one step of the server as a ServerTrace; one entry a user in every sequence.

    ``taken`` has user, number and sender's epoch of each packet taken in; ``fields`` are all
    others, as in ``ServerTrace.msg``; without lateness and compute [s] they are zero.
    """

    def each(values: Sequence[Value]) -> Any:
        return types.sequence([entry for value in values for entry in axes(value, dof)], "d")

    made = {name: each([fields.pop(name)]) for name in OF_OBJECT}
    made |= {name: each(fields.pop(name)) for name in OF_AVATARS}
    made |= {name: _scalars(types, fields.pop(name)) for name in ("energy_u_s", "energy_v_s")}
    made |= {name: scalar(fields.pop(name)) for name in ("kinetic", "potential", "dissipated")}
    return types.ServerTrace(
        stamp=time_message(types, stamp_ns),
        dof=dof,
        state=types.sequence([int(entry) for entry in state], "B"),
        contact=types.flags(contact),
        **made,
        **_accounts(types, accounts),
        **_taken(types, "user", taken),
        **{"lateness": 0.0, "compute": 0.0} | fields,
    )


def _taken(
    types: MessageTypes, place: str, packets: Sequence[tuple[int, int, int]]
) -> dict[str, Any]:
    columns = zip(*packets, strict=True) if packets else ((), (), ())
    return {
        f"taken_{name}": types.sequence([value & _UINT32 for value in column], "I")
        for name, column in zip((place, "seq", "epoch"), columns, strict=True)
    }


def _accounts(types: MessageTypes, accounts: Mapping[str, Value]) -> dict[str, Any]:
    return {"account_names": list(accounts), "accounts": _scalars(types, accounts.values())}


def _scalars(types: MessageTypes, values: Iterable[Value]) -> Any:
    return types.sequence([scalar(entry) for entry in values], "d")
