# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session's own messages in a recording; the others are counted and left out.

A ROS domain is open: any program on it can publish on the topics of a session. A message is left
out when

* its fields do not fit together (:mod:`pmwvc_core.runtime.misfits`);
* it comes from another publisher. Every start of a node draws an epoch, and a node that is started
  again follows its predecessor in time. Of epochs that overlap in time the one with the most
  messages stays; a trace's epoch is also the epoch of the packets that its node sends, so where
  packets were recorded, a trace without packets is another publisher's;
* it is out of sequence: its number comes again, or its clock fits neither its neighbours' nor the
  order of recording.

What is left out changes no verdict. It is an event of kind ``stranger``.
"""

import bisect
import itertools
from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pmwvc_analysis.recording import clocks
from pmwvc_analysis.recording.format import schemas
from pmwvc_analysis.recording.sequence import Numbered
from pmwvc_core.numeric import Integers
from pmwvc_core.plural import count
from pmwvc_core.runtime.misfits import misfit

LARGEST_JUMP = 1_000_000  # numbers missing at once: more than two hours of packets
LATEST_NS = 1 << 62  # log times beyond overflow
CLOCK_NS = 1_000_000_000  # a single message whose clock differs by this much from its neighbours'


@dataclass
class TopicMessages:
    """The decoded messages of one topic, their numbers, and when each was recorded [ns]."""

    log_ns: list[int] = field(default_factory=list)
    messages: list[Any] = field(default_factory=list)
    numbers: list[Numbered] = field(default_factory=list)


Topics = dict[str, TopicMessages]
Events = list[dict[str, Any]]


def keep_own(by_topic: Topics, types: Mapping[str, str]) -> Events:
    """Remove from ``by_topic`` what is not the session's own; return that as events."""
    found: Events = []
    for topic, kind in types.items():
        name, series = kind.rpartition("/")[2], by_topic[topic]
        problems = [
            misfit(name, message) if log_ns < LATEST_NS else f"recorded at {log_ns} ns"
            for log_ns, message in zip(series.log_ns, series.messages, strict=True)
        ]
        why = f"whose fields do not fit together ({next(filter(None, problems), '')})"
        found += _keep(topic, series, [problem is None for problem in problems], why)
    for topic, epochs in _own_epochs(by_topic, types).items():
        series = by_topic[topic]
        own = [int(message.epoch) in epochs for message in series.messages]
        found += _keep(topic, series, own, "from another publisher")
    for topic, kind in types.items():
        series, why = by_topic[topic], "out of sequence"
        found += _keep(topic, series, _continuing(series, kind), why)
    return found


def _keep(topic: str, series: TopicMessages, own: list[bool], why: str) -> Events:
    """Keep the messages of a topic for which ``own`` is true; return an event of the others."""
    if not (left_out := own.count(False)):
        return []
    first_ns = series.log_ns[own.index(False)]
    kept: list[list[Any]] = [series.log_ns, series.messages, series.numbers]
    for values in kept:
        values[:] = itertools.compress(values, own)
    what = f"{count(left_out, 'message')} on {topic} {why}, left out"
    return [{"time_ns": first_ns, "who": topic, "kind": "stranger", "what": what}]


def _own_epochs(by_topic: Topics, types: Mapping[str, str]) -> dict[str, set[int]]:
    """Return the session's own epochs on every topic that carries one."""
    waves = {t: _spans(by_topic[t]) for t, kind in types.items() if kind == schemas.WAVE}
    own: dict[str, set[int]] = {}
    of_sender: dict[str, set[int]] = {}
    for topic, kind in types.items():
        if kind not in (schemas.MASTER_TRACE, schemas.SERVER_TRACE):
            continue
        node = _sender(topic)
        sent = {epoch for name, spans in waves.items() if _sender(name) == node for epoch in spans}
        own[topic] = of_sender[node] = _in_turn(_spans(by_topic[topic]), sent)
    for topic, kind in types.items():
        if kind in (schemas.WAVE, schemas.RECEPTION):
            known, spans = of_sender.get(_sender(topic), set()), _spans(by_topic[topic])
            own[topic] = _in_turn(spans, known)
            if kind == schemas.RECEPTION and own[topic] & known:  # a start that no trace has yet
                ended_ns = max(spans[epoch][1] for epoch in own[topic])
                own[topic] |= {epoch for epoch, (first, *_) in spans.items() if first > ended_ns}
    return own


def _sender(topic: str) -> str:
    """Return the node that publishes on a topic, or whose packets it carries: ``server``, a user's
    name.
    """
    *_, owner, kind = ["", *topic.strip("/").split("/")]
    return "server" if kind == "wave_down" else owner


def _spans(series: TopicMessages) -> dict[int, tuple[int, int, int]]:
    """Return per epoch the first and the last log time [ns] and the number of messages."""
    times: dict[int, list[int]] = defaultdict(list)
    for log_ns, message in zip(series.log_ns, series.messages, strict=True):
        times[int(message.epoch)].append(log_ns)
    return {epoch: (min(each), max(each), len(each)) for epoch, each in times.items()}


def _in_turn(spans: dict[int, tuple[int, int, int]], known: Collection[int]) -> set[int]:
    """Return the epochs that follow one another, those with most messages first."""
    candidates = {e: s for e, s in spans.items() if e in known} or spans
    accepted: dict[int, tuple[int, int, int]] = {}
    for epoch, (first, last, seen) in sorted(candidates.items(), key=lambda item: -item[1][2]):
        if all(last <= begin or first >= end for begin, end, _ in accepted.values()):
            accepted[epoch] = (first, last, seen)
    return set(accepted)


def _continuing(series: TopicMessages, kind: str) -> list[bool]:
    """Tell which messages continue one another, publisher by publisher."""
    numbers = np.array([entry.first for entry in series.numbers], dtype=np.int64)
    trace = kind in (schemas.MASTER_TRACE, schemas.SERVER_TRACE)
    if kind == schemas.MASTER_TRACE:
        numbers = np.array([message.first_tick for message in series.messages], dtype=np.int64)
    logs = np.array(series.log_ns, dtype=np.int64)
    streams: dict[str, list[int]] = defaultdict(list)
    for row, entry in enumerate(series.numbers):
        streams[entry.stream].append(row)
    kept = np.zeros(len(numbers), dtype=bool)
    for stream in streams.values():
        rows = np.array(stream)
        rows = rows[np.argsort(numbers[rows], kind="stable")]
        if kind != schemas.WAVE:  # a link may deliver a packet twice
            rows = rows[np.diff(numbers[rows], prepend=-1) > 0]
        # the largest group of numbers without a jump that no loss explains
        cuts = np.flatnonzero(np.diff(numbers[rows]) > LARGEST_JUMP) + 1
        rows = max(np.split(rows, cuts), key=len)
        if trace:
            starts = clocks.monotonic_times([series.messages[row] for row in rows])
            increasing = _increasing(starts)
            rows, starts = rows[increasing], starts[increasing]
            if len(rows) > 1:  # as late as a neighbour, or recorded between both (it stood still)
                near = np.abs(np.diff((logs[rows] - starts).astype(float))) < CLOCK_NS
                after = np.diff(logs[rows]) >= 0
                between = np.array([False, *(after[1:] & after[:-1]), False])
                rows = rows[np.append(near, False) | np.append(False, near) | between]
        kept[rows] = True
    return kept.tolist()


def _increasing(values: Integers) -> Integers:
    """Return the indices of a longest strictly increasing subsequence."""
    if len(values) < 2 or (np.diff(values) > 0).all():
        return np.arange(len(values))
    ends: list[int] = []  # ends[n]: least last value of a subsequence of n + 1 values
    lengths = []  # of the longest subsequence that ends with a value, less one
    for value in values.tolist():
        length = bisect.bisect_left(ends, value)
        ends[length : length + 1] = [value]
        lengths.append(length)
    chain: list[int] = []
    for index in reversed(range(len(values))):
        wanted = len(ends) - 1 - len(chain)
        if lengths[index] == wanted and (not chain or values[index] < values[chain[-1]]):
            chain.append(index)
    return np.array(chain[::-1])
