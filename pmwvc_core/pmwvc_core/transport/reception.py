# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of one end of a link: what it has received, and the path as it sees it."""

import math

from pmwvc_core.transport.packet import Verdict
from pmwvc_core.transport.path import PathEstimate
from pmwvc_core.transport.receiver import Receiver

_TAKEN = (Verdict.ACCEPTED, Verdict.NEW_EPOCH, Verdict.DUPLICATE, Verdict.REORDERED)
REFUSED = {each.name.lower(): each for each in Verdict if each not in _TAKEN}  # by message field
ROUND_TRIP = "round trip [ms]"  # of diagnostics
PASSAGE = (  # fields of the Reception message
    *("delay_least", "delay_mean", "delay_max", "jitter"),  # [s] of packets that come in
    "delay_open",  # [s] bound of these; 0 where both ends read one clock
    *("offset", "drift", "drift_open"),  # sender's clock less the receiver's [s], change, bound
    "round_trip",  # [s] the least
)


def counts(inbox: Receiver, *, other_controller: int = 0) -> dict[str, int]:
    """Return the counts of a receiver by the names of the Reception message."""
    by_verdict = inbox.counts
    beginnings = by_verdict[Verdict.NEW_EPOCH]
    return {
        "accepted": by_verdict[Verdict.ACCEPTED] + beginnings,
        "beginnings": beginnings,
        "lost": inbox.lost,
        "duplicate": by_verdict[Verdict.DUPLICATE],
        "reordered": by_verdict[Verdict.REORDERED],
        **{name: by_verdict[verdict] for name, verdict in REFUSED.items()},
        "other_controller": other_controller,
    }


def passage(path: PathEstimate | None) -> dict[str, float]:
    """Return what an estimate says of the packets that come in, by the names of the Reception
    message; NaN where nothing is known.
    """
    if path is None:
        return dict.fromkeys(PASSAGE, math.nan)
    into = path.into
    delays = (into.least_s, into.mean_s, into.most_s, into.jitter_s, path.open_s)
    clocks = (path.offset_s, path.drift_ppm * 1e-6, path.drift_open_ppm * 1e-6)
    return dict(zip(PASSAGE, (*delays, *clocks, path.round_trip_s), strict=True))


def diagnostics(inbox: Receiver, *, out: str, into: str) -> dict[str, object]:
    """Return what a receiver has seen for people, by name; ``out`` and ``into`` name the
    directions.
    """
    trip, path = inbox.round_trip_s, inbox.path.estimate()
    found: dict[str, object] = {
        "packets lost": inbox.lost,
        ROUND_TRIP: "unknown" if trip is None else f"{trip * 1e3:.1f}",
    }
    if path is None:
        found |= {f"delay {out}": "unknown", f"delay {into}": "unknown"}
    else:
        for name, way in ((out, path.out), (into, path.into)):
            delay = f"{way.mean_s * 1e3:.2f} (least {way.least_s * 1e3:.2f})"
            found[f"delay {name} [ms]"] = delay
            found[f"jitter {name} [ms]"] = f"{way.jitter_s * 1e3:.3f}"
        found["clocks"] = (
            "one clock: delays are exact"
            if path.one_clock
            else f"{path.offset_s:+.6f} s apart, drift {path.drift_ppm:+.1f} +- "
            f"{path.drift_open_ppm:.1f} ppm; round trip known, its halves within "
            f"+-{path.open_s * 1e3:.2f} ms"
        )
    return found | {f"packets {verdict.value}": inbox.counts[verdict] for verdict in Verdict}
