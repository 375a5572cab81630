# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of both loops, as MasterTrace and ServerTrace messages."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pmwvc_core.numeric import Value
from pmwvc_core.runtime.messages.fields import OF_OBJECT, PER_AXIS, PER_TICK
from pmwvc_core.runtime.messages.types import MessageTypes, axes, scalar, time_message
from pmwvc_core.traces import ENERGIES, OF_AVATARS

_UINT32 = 0xFFFFFFFF


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

    ``series`` are the fields of each tick by name, row-major; ``taken`` has tick, number and
    sender's epoch of each packet taken in; ``energy`` holds ENERGIES at the end of the block [J],
    ``accounts`` the energies that only this controller keeps [J]. ``fields`` are all others, as in
    ``MasterTrace.msg``.
    """
    return types.MasterTrace(
        stamp=time_message(types, stamp_ns),
        **{name: types.sequence(series[name], "d") for name in PER_AXIS},
        **{name: types.sequence(series[name], code) for name, code in PER_TICK.items()},
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
