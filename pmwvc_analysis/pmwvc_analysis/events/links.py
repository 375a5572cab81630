# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Events of the links: times without any delivered packet, found from the fates of the packets."""

from collections.abc import Iterator

import numpy as np

from pmwvc_analysis.events.event import Event, event
from pmwvc_core.plural import count
from pmwvc_core.traces import FateTraces, SessionTraces

SILENT_S = 0.1
INTERVALS = 5.0  # of the usual interval between two packets
MOST = 10


def silences(traces: SessionTraces) -> Iterator[Event]:
    """Yield for every link when nothing came out of it for long though packets went in."""
    zeros = traces.metadata.get("fate_zero_ns", {})
    for name, fates in traces.fates.items():
        found = list(_of_link(fates))
        for start_ns, length_s, lost in found[:MOST]:
            what = (
                f"nothing delivered for {length_s:.3f} s ({count(lost, 'packet')} lost or dropped)"
            )
            start_s = (start_ns - zeros.get(name, 0)) * 1e-9
            yield event(start_s, f"link {name}", "link", what)
        if len(found) > MOST:
            start_s = (found[MOST][0] - zeros.get(name, 0)) * 1e-9
            what = f"silent {count(len(found) - MOST, 'more time')}"
            yield event(start_s, f"link {name}", "link", what)


def _of_link(fates: FateTraces) -> Iterator[tuple[int, float, int]]:
    out = np.sort(fates.time_out_ns[fates.time_out_ns > 0])
    if len(out) < 3:
        return
    steps = np.diff(out) * 1e-9
    usual = float(np.median(steps))
    numbers = np.sort(fates.number)
    for row in np.flatnonzero(steps > max(SILENT_S, INTERVALS * usual)).tolist():
        start, end = int(out[row]), int(out[row + 1])
        came = (fates.time_in_ns > start) & (fates.time_in_ns < end)
        if not came.any():
            continue  # nothing was sent: that is the sender's event
        first, last = fates.number[came].min(), fates.number[came].max()
        held = np.searchsorted(numbers, last, "right") - np.searchsorted(numbers, first)
        if held < last - first + 1:
            continue  # fates are missing in the recording
        lost = int((fates.time_out_ns[came] == 0).sum())
        yield start, float(steps[row]), lost
