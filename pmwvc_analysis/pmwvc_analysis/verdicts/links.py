# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The counts and delays of each emulated link: from its packet fates, else from its own counts."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.recording.link_blocks import reordered
from pmwvc_analysis.recording.losses import DROPPED, came_out
from pmwvc_analysis.traces.reductions import number, percentiles
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.numeric import Array
from pmwvc_core.plural import count
from pmwvc_core.traces import FateTraces, SessionTraces


def link_summaries(traces: SessionTraces) -> list[dict[str, Any]]:
    """Return the entries of ``links`` of a summary."""
    found = [_from_fates(fates) for fates in traces.fates.values()]
    found += [
        _from_states(link, states, traces.duration_s)
        for link, states in traces.link_states.items()
        if link not in traces.fates
    ]
    return sorted(found, key=lambda entry: str(entry["name"]))


COUNTED = (
    ("lost", "lost"),
    ("dropped", "dropped by a full queue"),
    ("duplicated", "delivered twice"),
    ("reordered", "overtaken by a later one"),
    ("corrupted", "delivered with a bit flipped"),
)


def count_texts(link: Mapping[str, Any]) -> str:
    """Return in words what a link did to its packets."""
    found = [f"{link[name]} {text}" for name, text in COUNTED if link[name]]
    return f"of {count(link['sent'], 'packet')} {', '.join(found) or 'none was changed'}"


def _from_fates(fates: FateTraces) -> dict[str, Any]:
    out = came_out(fates)
    return {
        "name": fates.link,
        "sent": int((fates.fate != FateKind.DUPLICATE).sum()),
        "received": int(out.sum()),
        "lost": int((fates.fate == FateKind.LOST).sum()),
        "duplicated": int((fates.fate == FateKind.DUPLICATE).sum()),
        "reordered": int(reordered(fates).sum()),
        "corrupted": int((fates.cause == Cause.CORRUPTION).sum()),
        "dropped": int(np.isin(fates.fate, DROPPED).sum()),
        "delay_s": percentiles((fates.time_out_ns - fates.time_in_ns)[out].astype(float) * 1e-9),
        "rate_hz": _rate_hz(fates.time_out_ns[out]),
    }


def _rate_hz(times_ns: NDArray[np.int64]) -> float | None:
    """Return the mean rate between the first and the last of these times."""
    if len(times_ns) < 2:
        return None
    span_s = float(times_ns.max() - times_ns.min()) * 1e-9
    return number((len(times_ns) - 1) / span_s) if span_s > 0.0 else None


def _from_states(link: str, states: dict[str, Array], duration_s: float) -> dict[str, Any]:
    """Return the last counts; percentiles of the delay are not known from them."""

    def last(name: str) -> int:
        return int(states[name][-1]) if name in states else 0  # one that is new

    received = last("out_count")
    others = ("lost", "duplicated", "reordered", "corrupted", "dropped")
    return {
        "name": link,
        "sent": last("in_count"),
        "received": received,
        **{name: last(name) for name in others},
        "delay_s": {"p50": None, "p99": None, "max": number(states["delay_max"].max())},
        "rate_hz": number(received / duration_s) if duration_s > 0.0 else None,
    }
