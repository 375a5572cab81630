# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The limits of tc-netem: settings that ``mode = netem`` has to refuse."""

from collections.abc import Iterable

from pmwvc_core.network.effects.record import LinkEffect
from pmwvc_core.params import LinkParams


def netem_conflict(params: LinkParams, records: Iterable[LinkEffect]) -> str:
    """Return what of these effects ``mode = netem`` cannot do; empty where it can do all."""
    if not params.as_linux:
        return ""
    for record in records:
        if not record.linux:
            name = record.parameters[0]
            given = f"{name} = {getattr(params, name)!r}"
            return f"{given}: must be {record.off!r} with mode = netem: Linux has no such thing"
    if params.queue_bytes:
        return f"queue_bytes = {params.queue_bytes}: must be 0 with mode = netem: Linux has none"
    if params.keep_order and any(record.spreads for record in records):
        return "keep_order = True: must be false with mode = netem: jitter reorders there"
    models = {
        "loss": params.loss,
        "ge_p": params.ge_p or params.ge_good,
        "markov_p13": params.markov_p13 or params.markov_p14,
    }
    given = " and ".join(
        f"{name} = {getattr(params, name):g}" for name, on in models.items() if on
    )
    if sum(bool(on) for on in models.values()) > 1:
        return f"{given}: must be one model of loss with mode = netem"
    return ""
