# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The counts and delays of each emulated link, and what came of its packets at their receiver."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from pmwvc_analysis.recording.links import DROPPED, came_out, reordered
from pmwvc_analysis.traces.arrivals import left_out
from pmwvc_analysis.traces.sums import number, percentiles
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import FateTraces, ReceptionTraces, SessionTraces
from pmwvc_core.words import count

COUNTED = (
    ("lost", "lost"), ("dropped", "dropped by a full queue"), ("duplicated", "delivered twice"),
    ("reordered", "overtaken by a later one"), ("corrupted", "delivered with a bit flipped"),
)  # fmt: skip
CAME = {
    "duplicate": "came again",
    "reordered": "came behind a newer one",
    "corrupted": "came corrupted",
}
OF_SENDERS = {
    "stale": "of a sender that had left, or far from its numbers", "stranger": "of another sender",
    "other_session": "of another session", "forged": "without the user's token",
    "flood": "beyond the rate of a sender", "malformed": "that were no packets",
    "not_finite": "with numbers that are not finite",
    "wrong_length": "of other degrees of freedom", "wrong_period": "of another period",
    "too_large": "with waves beyond any legal device",
    "other_controller": "of another kind of controller",
}  # fmt: skip


def link_summaries(traces: SessionTraces) -> list[dict[str, Any]]:
    """Return the entries of ``links`` of a summary."""
    found = map(_from_fates, traces.fates.values())
    return sorted(found, key=lambda entry: str(entry["name"]))


def count_texts(link: Mapping[str, Any]) -> str:
    """Return in words what a link did to its packets."""
    found = [f"{link[name]} {text}" for name, text in COUNTED if link[name]]
    return f"of {count(link['sent'], 'packet')} {', '.join(found) or 'none was changed'}"


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
        text, ratio = counts_text(received), saved.get(link)
        if ratio is not None:
            words = "of the packets; none of these is lost."
            text += f" The sender's deadband left out {ratio:.0%} {words}"
        entry = {
            "name": link,
            "counts": received.counts,
            "path": None if passage["round_trip"] is None else passage,
            "left_out": ratio,
            "text": text,
            "path_text": path_text(received.passage),
        }
        found.append(entry)
    return found


def counts_text(received: ReceptionTraces) -> str:
    """Return what came in, in a sentence."""
    counts = received.counts
    came = [f"{count(counts['lost'], 'number')} never came"] if counts["lost"] else []
    came += [f"{counts[name]} {words}" for name, words in CAME.items() if counts[name]]
    came = came or ["none lost, repeated, out of order or corrupted"]
    text = ", ".join([f"{count(counts['accepted'], 'packet')} accepted", *came])
    others = [f"{counts[n]} {words}" for n, words in OF_SENDERS.items() if counts[n]]
    text += f"; refused: {', '.join(others)}" if others else ""
    return f"{text}."


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
    return (
        f"{text}, within +-{ms['delay_open']:.2f} ms: both directions together take "
        f"{ms['round_trip']:.2f} ms at least, which is known; how that divides is not, because an "
        "offset between two clocks and a constant asymmetry of the path look the same. Sender's "
        f"clock {passage['offset']:+.6f} s from the receiver's, drift "
        f"{passage['drift'] * 1e6:+.1f} +- {passage['drift_open'] * 1e6:.1f} ppm."
    )
