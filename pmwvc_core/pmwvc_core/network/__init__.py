# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The network between the two ends: links, their effects on packets, and the record of fates."""

from pmwvc_core.network.delay_trace import DelayTrace, load_delay_trace
from pmwvc_core.network.fates import FateBlock, FateLog
from pmwvc_core.network.in_flight import Cause, Fate, FateKind, LinkCounters
from pmwvc_core.network.link import Link, stream_of
from pmwvc_core.network.recorded_link import RecordedFate, RecordedLink

__all__ = [
    "Cause",
    "DelayTrace",
    "Fate",
    "FateBlock",
    "FateKind",
    "FateLog",
    "Link",
    "LinkCounters",
    "RecordedFate",
    "RecordedLink",
    "load_delay_trace",
    "stream_of",
]
