# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The counts and delays of each emulated link, and what came of its packets at their receiver."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pmwvc_analysis.recording.links import DROPPED, came_out, reordered
from pmwvc_analysis.traces.arrivals import left_out
from pmwvc_analysis.traces.sums import number, percentiles
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import FateTraces, ReceptionTraces, SessionTraces
from pmwvc_core.words import count

DONE = ("lost", "dropped", "duplicated", "reordered", "corrupted")  # by a link
SEEN = ("lost", "duplicate", "reordered", "corrupted")  # by a receiver, who refuses the others


def link_summaries(traces: SessionTraces) -> list[dict[str, Any]]:
    """Return the entries of ``links`` of a summary."""
    return [_from_fates(fates) for _, fates in sorted(traces.fates.items())]


def count_texts(link: Mapping[str, Any]) -> str:
    """Return in words what a link did to its packets."""
    return f"of {count(link['sent'], 'packet')} {_named(link, DONE) or 'none was changed'}"


def _from_fates(fates: FateTraces) -> dict[str, Any]:
    out = came_out(fates)
    span_s = float(np.ptp(fates.time_out_ns[out])) * 1e-9 if out.any() else 0.0
    return {
        "name": fates.link, "sent": int((fates.fate != FateKind.DUPLICATE).sum()),
        "received": int(out.sum()), "lost": int((fates.fate == FateKind.LOST).sum()),
        "duplicated": int((fates.fate == FateKind.DUPLICATE).sum()),
        "reordered": int(reordered(fates).sum()),
        "corrupted": int((fates.cause == Cause.CORRUPTION).sum()),
        "dropped": int(np.isin(fates.fate, DROPPED).sum()),
        "delay_s": percentiles((fates.time_out_ns - fates.time_in_ns)[out].astype(float) * 1e-9),
        "rate_hz": number((out.sum() - 1) / span_s) if span_s > 0.0 else None,
    }  # fmt: skip


def reception_summaries(traces: SessionTraces, scenario: Scenario | None) -> list[dict[str, Any]]:
    """Return the entries of ``receptions`` of a summary."""
    found, saved = [], left_out(traces, scenario)
    for link, received in sorted(traces.receptions.items()):
        passage = {name: number(value) for name, value in received.passage.items()}
        entry = {
            "name": link,
            "counts": received.counts,
            "path": None if passage["round_trip"] is None else passage,
            "left_out": saved.get(link),
            "text": counts_text(received, saved.get(link)),
            "path_text": path_text(received.passage),
        }
        found.append(entry)
    return found


def counts_text(received: ReceptionTraces, left_out: float | None) -> str:
    """Return what came in, and the ratio that a deadband left out, in words."""
    counts = received.counts
    came = _named(counts, SEEN) or "none lost, duplicate, reordered or corrupted"
    others = _named(counts, [n for n in counts if n not in ("accepted", "beginnings", *SEEN)])
    refused = f"; refused: {others}" if others else ""
    text = f"{count(counts['accepted'], 'packet')} accepted, {came}{refused}."
    if left_out is None:
        return text
    saved = f"left out {left_out:.0%} of the packets; none of these is lost."
    return f"{text} The sender's deadband {saved}"


def _named(counts: Mapping[str, Any], names: Sequence[str]) -> str:
    return ", ".join(f"{counts[n]} {n.replace('_', ' ')}" for n in names if counts[n])


def path_text(passage: dict[str, float]) -> str:
    """Return the delay of a direction in a sentence, with what is known of it and what is not."""
    if not math.isfinite(passage["round_trip"]):
        return "Delay not known: in no second did both packets and echoes arrive."
    ms = {name: value * 1e3 for name, value in passage.items()}
    text = (
        f"Delay from sending to reception {ms['delay_mean']:.2f} ms in the last second (least of "
        f"the last minute {ms['delay_least']:.2f} ms), jitter {ms['jitter']:.3f} ms"
    )
    if passage["delay_open"] == 0.0:
        return f"{text}; both ends read one clock."
    drift, drift_open = (f"{1e6 * passage[name]:.1f}" for name in ("drift", "drift_open"))
    return (
        f"{text}, within +-{ms['delay_open']:.2f} ms: of two clocks only the sum of both "
        f"directions is known, {ms['round_trip']:.2f} ms at least. Sender's clock "
        f"{passage['offset']:+.6f} s from the receiver's, drift {drift} +- {drift_open} ppm."
    )
