# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The messages an emulator would have published of one link, made from its packet fates."""

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np

from pmwvc_analysis.recording.losses import DROPPED
from pmwvc_core.network.fates import COLUMNS as PUBLISHED
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.numeric import Flags
from pmwvc_core.params import LinkParams
from pmwvc_core.runtime import messages as build
from pmwvc_core.runtime.messages import MessageTypes
from pmwvc_core.traces import FateTraces

BLOCK_NS = 500_000_000
STATE_NS = 1_000_000_000
COLUMNS = {name: name for name in PUBLISHED} | {"bytes": "size_bytes"}


def fate_blocks(types: MessageTypes, fates: FateTraces, start: int) -> Iterator[tuple[int, Any]]:
    """Yield PacketFate messages of half a second with the time of the last packet in each [ns]."""
    blocks = fates.time_in_ns // BLOCK_NS
    edges = [0, *(np.flatnonzero(np.diff(blocks)) + 1).tolist(), len(blocks)]
    for first, after in itertools.pairwise(edges):
        if first == after:
            continue
        part = slice(first, after)
        at_ns = int(fates.time_in_ns[part].max())
        yield (
            at_ns,
            build.packet_fates(
                types,
                stamp_ns=start + at_ns,
                link=fates.link,
                first=first + 1,
                **{column: getattr(fates, name)[part] for column, name in COLUMNS.items()},
            ),
        )


def state_blocks(
    types: MessageTypes, fates: FateTraces, params: LinkParams, start: int, *, seed: int
) -> Iterator[tuple[int, Any]]:
    """Yield one LinkState message a second, with its time [ns]."""
    if not len(fates.number):
        return
    out = fates.time_out_ns > 0
    delays = (fates.time_out_ns - fates.time_in_ns) * 1e-9
    overtaken = reordered(fates)
    end = int(max(fates.time_in_ns.max(), fates.time_out_ns.max()))
    for seq, at_ns in enumerate(range(STATE_NS, end + STATE_NS, STATE_NS), start=1):
        came, left = fates.time_in_ns < at_ns, out & (fates.time_out_ns < at_ns)
        recent = left & (fates.time_out_ns >= at_ns - STATE_NS)
        now = delays[recent] if recent.any() else np.zeros(1)
        kinds = fates.fate[came]
        counts = {
            "in_count": int((came & (fates.fate != FateKind.DUPLICATE)).sum()),
            "out_count": int(left.sum()),
            "lost": int((kinds == FateKind.LOST).sum()),
            "duplicated": int((kinds == FateKind.DUPLICATE).sum()),
            "reordered": int((overtaken & left).sum()),
            "corrupted": int((fates.cause[came] == Cause.CORRUPTION).sum()),
            "queued": int((came & out).sum() - left.sum()),
            "dropped": int(np.isin(kinds, DROPPED).sum()),
        }
        figures = {"delay_mean": now.mean(), "delay_min": now.min(), "delay_max": now.max()}
        message = build.link_state(
            types,
            stamp_ns=start + at_ns,
            link=fates.link,
            seq=seq,
            counts=counts,
            delays={name: float(value) for name, value in figures.items()}
            | {"delay_error_max": 0.0},
            rate_hz=float(recent.sum()) * 1e9 / STATE_NS,
            params=params,
            seed=seed,
        )
        yield at_ns, message


def reordered(fates: FateTraces) -> Flags:
    """Tell which records left the link after a later packet of the same sender had left."""
    result = np.zeros(len(fates.seq), dtype=np.bool_)
    for epoch in np.unique(fates.epoch):
        rows = np.flatnonzero((fates.epoch == epoch) & (fates.time_out_ns > 0))
        rows = rows[np.argsort(fates.time_out_ns[rows], kind="stable")]
        newest = np.maximum.accumulate(fates.seq[rows])
        result[rows] = fates.seq[rows] < newest
    return result
