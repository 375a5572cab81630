# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Building messages: one conversion for live nodes and for recordings written without ROS. Every
builder takes the message classes first: :func:`live_types` for rclpy, :func:`types_from` for a
typestore of rosbags. Fields given by keyword have the names of the ``.msg`` files.
"""

from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from types import SimpleNamespace
from typing import Any, TypeAlias

import numpy as np

from pmwvc_core.ends.inbox import scalar, vector
from pmwvc_core.network.in_flight import COLUMNS
from pmwvc_core.numeric import Value
from pmwvc_core.traces import ENERGIES, OF_AVATARS
from pmwvc_core.transport.packet import WavePacket

NS_PER_S = 1_000_000_000
# What a node publishes for a recorder is kept at the sender, and sent again to one that missed it.
KEPT = 10_000  # messages of a topic: ten seconds at 1 kHz

PER_AXIS = ("x", "xd", "f_h", "f_m", "f_applied", "u_m", "u_m_lp", "v_m")  # of a tick
PER_TICK = {"lateness": "f", "compute": "f", "looked": "I"}  # typecodes
OF_OBJECT = ("x_o", "xd_o", "target")  # of a step

_UINT32 = 0xFFFFFFFF
_OURS = ("Wave", "MasterTrace", "ServerTrace", "PacketFate", "Reception")
_PACKAGES = dict.fromkeys(_OURS, "pmwvc_msgs")
_PACKAGES |= {"Time": "builtin_interfaces", "String": "std_msgs"}

# Message classes by name; ``sequence(values, kind)`` by typecode or numpy type.
MessageTypes: TypeAlias = SimpleNamespace


def live_types() -> MessageTypes:
    """Return the message classes of rclpy."""
    return MessageTypes(
        **{n: getattr(import_module(f"{package}.msg"), n) for n, package in _PACKAGES.items()},
        sequence=lambda values, _: values,
    )


def types_from(classes: Mapping[str, Any]) -> MessageTypes:
    """Return the message classes of ``typestore.types`` of rosbags that knows ``pmwvc_msgs``."""
    return MessageTypes(
        **{n: classes[f"{package}/msg/{n}"] for n, package in _PACKAGES.items()},
        sequence=lambda values, kind: np.array(values, dtype=kind),
    )


def record_of(topic: str) -> str:
    """Return the topic of waves for the recorder, reliable and apart from the loops'."""
    return f"{topic}/sent"


def time_message(types: MessageTypes, stamp_ns: int) -> Any:
    """Return a time [ns] as a message."""
    sec, nanosec = divmod(int(stamp_ns), NS_PER_S)
    return types.Time(sec=sec, nanosec=nanosec)


def nanoseconds(stamp: Any) -> int:
    """Return a time message in ns."""
    return int(stamp.sec) * NS_PER_S + int(stamp.nanosec)


def wave(types: MessageTypes, packet: WavePacket, stamp_ns: int, *, dof: int = 1) -> Any:
    """Return a packet as a Wave message of ``dof`` axes, as recordings hold it."""
    plain = ("sent_ns", "epoch", "seq", "period", "session")
    echo = ("echo_seq", "echo_sent_ns", "echo_hold_ns")
    signals = {n: vector(getattr(packet, n), dof) for n in ("wave", "integral", "position")}
    sequences = {**signals, "extra": packet.extra, "orientation": packet.orientation}
    return types.Wave(
        stamp=time_message(types, stamp_ns),
        energy=scalar(packet.energy),
        flags=packet.flags,
        check=0,
        tag=0,
        **{name: getattr(packet, name) for name in (*plain, *echo)},
        **{name: types.sequence(values, "d") for name, values in sequences.items()},
    )


def packet_fates(
    types: MessageTypes, *, stamp_ns: int, link: str, first: int, **columns: Sequence[int]
) -> Any:
    """Return a block of records, one entry a record in every column, as a PacketFate message."""
    found = {name: types.sequence(columns[name], kind) for name, kind in COLUMNS.items()}
    return types.PacketFate(stamp=time_message(types, stamp_ns), link=link, first=first, **found)


def master_trace(
    types: MessageTypes, series: Mapping[str, Any], *, taken: Sequence[tuple[int, int, int]],
    stamp_ns: int, energy: Mapping[str, Value], accounts: Mapping[str, Value],
    orientation: Sequence[float] = (), **fields: Any,
) -> Any:  # fmt: skip
    """Return one block of ticks as a MasterTrace message: ``series`` by name, row-major; ``taken``
    has tick, number and sender's epoch of each packet taken in; ``energy`` ENERGIES at its end
    [J], ``accounts`` those of the controller [J]. ``fields`` are all others.
    """
    return types.MasterTrace(
        stamp=time_message(types, stamp_ns),
        **{name: types.sequence(series[name], "d") for name in PER_AXIS},
        **{name: types.sequence(series[name], code) for name, code in PER_TICK.items()},
        **_taken(types, "tick", taken),
        **{f"energy_{name}": scalar(energy[name]) for name in ENERGIES},
        **_accounts(types, accounts),
        orientation=types.sequence(orientation, "d"),
        **fields,
    )


def server_trace(
    types: MessageTypes, *, stamp_ns: int, dof: int, state: Sequence[int], contact: Sequence[bool],
    taken: Sequence[tuple[int, int, int]], accounts: Mapping[str, Value],
    poses: Mapping[str, Sequence[float]], contacts: Sequence[float], **fields: Any,
) -> Any:  # fmt: skip
    """Return one step of the server as a ServerTrace, one entry a user in every sequence;
    ``taken`` has user, number and sender's epoch of each packet taken in; ``fields`` are all
    others.
    """

    def each(values: Sequence[Value]) -> Any:
        return types.sequence([entry for value in values for entry in vector(value, dof)], "d")

    made = {name: each([fields.pop(name)]) for name in OF_OBJECT}
    made |= {name: each(fields.pop(name)) for name in OF_AVATARS}
    made |= {name: _scalars(types, fields.pop(name)) for name in ("energy_u_s", "energy_v_s")}
    made |= {name: scalar(fields.pop(name)) for name in ("kinetic", "potential", "dissipated")}
    return types.ServerTrace(
        stamp=time_message(types, stamp_ns), dof=dof, bodies=list(poses),
        state=types.sequence([int(entry) for entry in state], "B"),
        contact=types.sequence([bool(touches) for touches in contact], "?"),
        poses=types.sequence([float(n) for pose in poses.values() for n in pose], "d"),
        contacts=types.sequence(list(contacts), "f"),
        **made, **_accounts(types, accounts), **_taken(types, "user", taken),
        **{"lateness": 0.0, "compute": 0.0} | fields,
    )  # fmt: skip


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
