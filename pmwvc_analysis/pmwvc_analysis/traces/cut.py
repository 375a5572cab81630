# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The traces of a session up to an instant."""

from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from pmwvc_core.numeric import Flags
from pmwvc_core.traces import FateTraces, PacketTraces, ServerTraces, SessionTraces, UserTraces

Table = TypeVar("Table", FateTraces, PacketTraces, ServerTraces, UserTraces)
OF_BLOCKS = ("block_time_s", "state", "block_number", "epoch", "changes")  # of a master


def until(traces: SessionTraces, end_s: float) -> SessionTraces:
    """Return what there was before ``end_s``, without users of whom nothing is left; the same
    object where that is everything.
    """
    if end_s >= traces.duration_s:
        return traces
    zeros = traces.metadata.get("fate_zero_ns", {})
    late = traces.metadata.get("server_lateness_s")
    server, metadata = traces.server, dict(traces.metadata)
    if server is not None:
        kept = server.time_s < end_s
        if late is not None and len(late) == len(kept):
            metadata["server_lateness_s"] = late[kept]
        server = with_rows(server, kept) if kept.any() else None
    users = [user_until(user, end_s) for user in traces.users if user.block_time_s[0] <= end_s]
    rows = {f"{user.name}/down": len(user.time_s) for user in users}
    steps = 0 if server is None else len(server.time_s)
    return replace(
        traces,
        duration_s=end_s,
        users=users,
        server=server,
        packets={t: with_rows(each, each.time_s < end_s) for t, each in traces.packets.items()},
        fates={
            link: with_rows(each, each.time_in_ns < round(end_s * 1e9) + zeros.get(link, 0))
            for link, each in traces.fates.items()
        },
        taken={
            link: each.before(steps if link.endswith("/up") else rows.get(link, 0))
            for link, each in traces.taken.items()
        },
        metadata=metadata,
    )


def user_until(user: UserTraces, end_s: float) -> UserTraces:
    """Return the ticks of the whole blocks that ended by then."""
    blocks = user.block_time_s <= end_s + 1e-9
    last_s = float(user.block_time_s[blocks][-1])
    found = with_rows(user, user.time_s < last_s - 0.5 * user.tick_s, blocks)
    reasons = zip(user.reason, blocks, strict=True)
    return replace(found, reason=[text for text, kept in reasons if kept])


def with_rows(table: Table, kept: Flags, blocks: Flags | None = None) -> Table:
    """Return some rows of a table of arrays; of a master some ticks and some blocks."""
    of_sums = kept if blocks is None else blocks
    changed: dict[str, Any] = {}
    for each in fields(table):
        values = getattr(table, each.name)
        if isinstance(values, np.ndarray) and len(values):
            is_of_blocks = blocks is not None and each.name in OF_BLOCKS
            changed[each.name] = values[of_sums if is_of_blocks else kept]
        elif isinstance(values, dict):
            changed[each.name] = {name: sums[of_sums] for name, sums in values.items()}
        elif isinstance(values, list) and isinstance(next(iter(values), None), np.ndarray):
            changed[each.name] = [part[kept] for part in values]
    return replace(table, **changed)
