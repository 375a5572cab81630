# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""LinkState and PacketFate messages: the state of a link and the fates of its packets."""

from collections.abc import Mapping, Sequence
from typing import Any

from pmwvc_core.params import LinkParams
from pmwvc_core.runtime.messages.types import MessageTypes, time_message


def link_state(
    types: MessageTypes,
    *,
    stamp_ns: int,
    link: str,
    seq: int,
    counts: Mapping[str, int],
    delays: Mapping[str, float],
    rate_hz: float,
    params: LinkParams,
    seed: int,
) -> Any:
    """Return counts, delays [s] and settings of a link as a LinkState message.

    Parameters
    ----------
    counts
        ``in_count, out_count, lost, duplicated, reordered, corrupted, queued, dropped``.
    delays
        ``delay_mean, delay_min, delay_max, delay_error_max`` since the last message [s].
    """
    settings = ("delay_s", "jitter_s", "jitter", "loss", "duplicate", "rate_limit_bps")
    return types.LinkState(
        stamp=time_message(types, stamp_ns),
        link=link,
        seq=seq,
        rate_hz=rate_hz,
        seed=seed,
        **counts,
        **delays,
        **{name: getattr(params, name) for name in settings},
    )


def packet_fates(
    types: MessageTypes,
    *,
    stamp_ns: int,
    link: str,
    first: int,
    epoch: Sequence[int],
    seq: Sequence[int],
    size: Sequence[int],
    time_in_ns: Sequence[int],
    time_due_ns: Sequence[int],
    time_out_ns: Sequence[int],
    fate: Sequence[int],
    cause: Sequence[int],
) -> Any:
    """Return a block of records, one entry a record in every sequence, as a PacketFate message."""
    return types.PacketFate(
        stamp=time_message(types, stamp_ns),
        link=link,
        first=first,
        epoch=types.sequence(epoch, "Q"),
        seq=types.sequence(seq, "I"),
        bytes=types.sequence(size, "I"),
        time_in_ns=types.sequence(time_in_ns, "q"),
        time_due_ns=types.sequence(time_due_ns, "q"),
        time_out_ns=types.sequence(time_out_ns, "q"),
        fate=types.sequence(fate, "B"),
        cause=types.sequence(cause, "B"),
    )
