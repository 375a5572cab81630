# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of one end of a link: what it has received, and the path as it sees it."""

import math
from dataclasses import asdict, dataclass

from pmwvc_core.transport.path import PathEstimate
from pmwvc_core.transport.receiver import Receiver
from pmwvc_core.transport.verdict import Verdict

REFUSED = {  # field of the Reception message -> verdict
    "stale": Verdict.STALE,
    "stranger": Verdict.STRANGER,
    "corrupted": Verdict.CORRUPTED,
    "other_session": Verdict.OTHER_SESSION,
    "forged": Verdict.FORGED,
    "flood": Verdict.FLOOD,
    "malformed": Verdict.MALFORMED,
    "not_finite": Verdict.NOT_FINITE,
    "wrong_length": Verdict.WRONG_LENGTH,
    "wrong_period": Verdict.WRONG_PERIOD,
    "too_large": Verdict.TOO_LARGE,
}


@dataclass(frozen=True)
class Passage:
    """Delay of the packets that come in and the clocks of both ends; NaN where not known.

    Attributes
    ----------
    delay_least, delay_mean, delay_max, jitter, delay_open
        Of this direction [s]; true within ``delay_open``, which is 0 where both read one clock.
    offset, drift, drift_open
        Sender's clock less the receiver's [s], its change per second and the bound of that.
    round_trip
        Least round trip [s].
    """

    delay_least: float = math.nan
    delay_mean: float = math.nan
    delay_max: float = math.nan
    jitter: float = math.nan
    delay_open: float = math.nan
    offset: float = math.nan
    drift: float = math.nan
    drift_open: float = math.nan
    round_trip: float = math.nan

    @classmethod
    def of(cls, path: PathEstimate | None) -> "Passage":
        """Return what an estimate says of the packets that come in."""
        if path is None:
            return cls()
        into = path.into
        return cls(
            into.least_s,
            into.mean_s,
            into.most_s,
            into.jitter_s,
            path.open_s,
            path.offset_s,
            path.drift_ppm * 1e-6,
            path.drift_open_ppm * 1e-6,
            path.round_trip_s,
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


def fields(passage: Passage) -> dict[str, float]:
    """Return a passage by the names of the Reception message."""
    return asdict(passage)


def diagnostics(path: PathEstimate | None, *, out: str, into: str) -> dict[str, object]:
    """Return a path for people, by name; ``out`` and ``into`` name the directions."""
    if path is None:
        return {f"delay {out}": "unknown", f"delay {into}": "unknown"}
    found: dict[str, object] = {}
    for name, way in ((out, path.out), (into, path.into)):
        found[f"delay {name} [ms]"] = f"{way.mean_s * 1e3:.2f} (least {way.least_s * 1e3:.2f})"
        found[f"jitter {name} [ms]"] = f"{way.jitter_s * 1e3:.3f}"
    if path.one_clock:
        return {**found, "clocks": "one clock: delays are exact"}
    return {
        **found,
        "clocks": f"{path.offset_s:+.6f} s apart, drift {path.drift_ppm:+.1f} +- "
        f"{path.drift_open_ppm:.1f} ppm; round trip known, its halves within "
        f"+-{path.open_s * 1e3:.2f} ms",
    }
