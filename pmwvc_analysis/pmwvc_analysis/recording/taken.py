# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The input of both loops, between trace messages and traces: which packets receivers were given
and when, and when changes of parameters were taken over.

Every trace message says it, tick by tick or of its step. A recording from before has none of it.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from pmwvc_core.numeric import Integers
from pmwvc_core.runtime.messages.fields import MasterTrace, ServerTrace, Trace
from pmwvc_core.traces import TakenTraces

Taken = tuple[int, int, int]  # tick of the block or index of the user, number, sender's epoch


def by_master(blocks: Sequence[MasterTrace]) -> TakenTraces | None:
    """Return what a master was given, by its blocks in the order of time; None: not recorded."""
    if not all(hasattr(block, "taken_seq") for block in blocks):
        return None
    first = np.cumsum([0, *(len(block.lateness) for block in blocks)])
    rows = [
        at + np.asarray(block.taken_tick, dtype=np.int64)
        for at, block in zip(first.tolist(), blocks, strict=False)
    ]
    return TakenTraces(
        np.concatenate(rows), _all(blocks, "taken_seq"), _all(blocks, "taken_epoch")
    )


def by_server(steps: Sequence[ServerTrace], users: Sequence[str]) -> dict[str, TakenTraces]:
    """Return what the server was given of each user, by its steps in the order of time."""
    if not all(hasattr(step, "taken_seq") for step in steps):
        return {}
    rows = np.repeat(np.arange(len(steps)), [len(step.taken_seq) for step in steps])
    names = np.array([step.users[user] for step in steps for user in step.taken_user], dtype=str)
    seq, epoch = _all(steps, "taken_seq"), _all(steps, "taken_epoch")
    found = {}
    for user in users:
        own = names == user
        found[user] = TakenTraces(rows[own], seq[own], epoch[own])
    return found


def _all(messages: Sequence[MasterTrace] | Sequence[ServerTrace], field: str) -> Integers:
    parts = [np.asarray(getattr(each, field), dtype=np.int64) for each in messages]
    return np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)


def looked_ns(messages: Sequence[MasterTrace] | Sequence[ServerTrace]) -> Integers:
    """Return when packets were taken in, behind the deadline of each tick or step [ns]; empty: not
    recorded.
    """
    known = messages if all(hasattr(each, "looked") for each in messages) else ()
    parts = [np.atleast_1d(np.asarray(each.looked, dtype=np.int64)) for each in known]
    return np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)


def changes(messages: Sequence[Trace]) -> Integers:
    """Return how many changes were taken over up to each message; empty: not recorded."""
    known = messages if all(hasattr(each, "changes") for each in messages) else ()
    return np.array([each.changes for each in known], dtype=np.int64)


def of_rows(taken: TakenTraces | None, first: int, after: int) -> Iterator[Taken]:
    """Yield what was taken in by rows of the traces, counted from the first of them."""
    if taken is None:
        return
    begin, end = np.searchsorted(taken.row, [first, after])
    for at in range(begin, end):
        yield int(taken.row[at]) - first, int(taken.seq[at]), int(taken.epoch[at])
