# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages of the links and of a node's health: Wave, PacketFate, LinkState, Reception and
DiagnosticArray. Fields given by keyword are those of the ``.msg`` files.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from pmwvc_core.network.in_flight import COLUMNS
from pmwvc_core.params import LinkParams
from pmwvc_core.runtime.messages.types import MessageTypes, axes, scalar, time_message
from pmwvc_core.transport.packet import WavePacket

_SETTINGS = ("delay_s", "jitter_s", "jitter", "loss", "duplicate", "rate_limit_bps")


def wave(types: MessageTypes, packet: WavePacket, stamp_ns: int, *, dof: int = 1) -> Any:
    """Return a packet as a Wave message, as recordings hold it; loops send bytes (:mod:`.wire`).

    A float stands for that value on each of ``dof`` axes.
    """
    plain = ("sent_ns", "epoch", "seq", "period", "session")
    echo = ("echo_seq", "echo_sent_ns", "echo_hold_ns")
    return types.Wave(
        stamp=time_message(types, stamp_ns),
        energy=scalar(packet.energy),
        flags=packet.message_flags,
        check=0,
        tag=0,
        **{name: getattr(packet, name) for name in (*plain, *echo)},
        **{
            name: types.sequence(axes(getattr(packet, name), dof), "d")
            for name in ("wave", "integral", "position")
        },
        extra=types.sequence(packet.extra, "d"),
    )


def packet_fates(
    types: MessageTypes, *, stamp_ns: int, link: str, first: int, **columns: Sequence[int]
) -> Any:
    """Return a block of records, one entry a record in every column, as a PacketFate message."""
    found = {name: types.sequence(columns[name], kind) for name, kind in COLUMNS.items()}
    return types.PacketFate(stamp=time_message(types, stamp_ns), link=link, first=first, **found)


def link_state(
    types: MessageTypes,
    *,
    stamp_ns: int,
    counts: Mapping[str, int],
    delays: Mapping[str, float],
    params: LinkParams,
    **fields: Any,
) -> Any:
    """Return counts (LinkCounters), delays since the last message (``delay_mean, delay_min,
    delay_max, delay_error_max`` [s]) and settings of a link as a LinkState message.
    """
    settings = {name: getattr(params, name) for name in _SETTINGS}
    stamp = time_message(types, stamp_ns)
    return types.LinkState(stamp=stamp, **counts, **delays, **settings, **fields)


def reception(types: MessageTypes, *, stamp_ns: int, **fields: Any) -> Any:
    """Return counts and passage (:mod:`pmwvc_core.transport.reception`) as a message."""
    return types.Reception(stamp=time_message(types, stamp_ns), **fields)


def diagnostic(
    types: MessageTypes, *, stamp_ns: int, level: int, values: Mapping[str, object], **fields: str
) -> Any:
    """Return the health of one node as a DiagnosticArray (level 0 fine, 1 warning, 2 error)."""
    pairs = [types.KeyValue(key=key, value=str(value)) for key, value in values.items()]
    level = types.octet(level)
    status = types.DiagnosticStatus(level=level, hardware_id="", values=pairs, **fields)
    header = types.Header(stamp=time_message(types, stamp_ns), frame_id="")
    return types.DiagnosticArray(header=header, status=[status])
