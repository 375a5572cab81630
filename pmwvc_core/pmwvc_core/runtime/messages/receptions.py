# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Reception messages: what one end of a link has received."""

from collections.abc import Mapping
from typing import Any

from pmwvc_core.runtime.messages.types import MessageTypes, time_message


def reception(
    types: MessageTypes,
    *,
    stamp_ns: int,
    epoch: int,
    seq: int,
    link: str,
    sender: int,
    counts: Mapping[str, int],
    passage: Mapping[str, float],
) -> Any:
    """Return counts and passage (:mod:`pmwvc_core.transport.reception`) as a message."""
    return types.Reception(
        stamp=time_message(types, stamp_ns),
        epoch=epoch,
        seq=seq,
        link=link,
        sender=sender,
        **counts,
        **passage,
    )
