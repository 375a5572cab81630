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

Each publisher numbers what it sends: packets and blocks by ``seq``, server steps by ``step``,
fates by the number of their first record. A number that never came, between the first and the last
that did, is missing; the first one of a publisher started while recording is 1, so what was lost
before it counts too.
"""

import itertools
from collections import Counter, defaultdict
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.recording import clocks, schemas
from pmwvc_analysis.recording.salvage import RawMessage
from pmwvc_core.numeric import Flags
from pmwvc_core.runtime.misfits import misfit
from pmwvc_core.words import count

LARGEST_JUMP = 1_000_000  # numbers missing at once: more than two hours of packets
CLOCK_NS = 1_000_000_000  # by which the clock of a single message differs from its neighbours'
TRACES = (schemas.MASTER_TRACE, schemas.SERVER_TRACE)
WITH_EPOCH = (*TRACES, schemas.WAVE, schemas.RECEPTION)


class Decoded(NamedTuple):
    """A decoded message, when it was recorded and published [ns], and its numbers: ``many`` of a
    publisher (epoch or link), from ``first`` on.
    """

    log_ns: int
    publish_ns: int
    message: Any
    stream: str
    first: int
    many: int = 1


def decoded(raw: RawMessage, message: Any) -> Decoded:
    """Return a message of a session with its numbers."""
    times = raw.log_ns, raw.publish_ns
    if raw.type_name == schemas.PACKET_FATE:
        return Decoded(*times, message, str(message.link), int(message.first), len(message.seq))
    number = message.step if raw.type_name == schemas.SERVER_TRACE else message.seq
    return Decoded(*times, message, f"{int(message.epoch):016x}", int(number))


class Series(NamedTuple):
    """The messages of one topic, of one type, in the order of the file."""

    type_name: str
    rows: list[Decoded]

    @property
    def messages(self) -> list[Any]:
        """The messages alone."""
        return [row.message for row in self.rows]

    def gaps(self) -> dict[str, tuple[int, int]]:
        """Return how many numbers of each publisher never came, and how many did. One that comes
        again counts again: only an emulated link delivers a packet twice, and its fates tell what
        is missing.
        """
        seen: Counter[str] = Counter()
        newest: Counter[str] = Counter()
        for *_, stream, first, many in self.rows:
            seen[stream] += many
            newest[stream] = max(newest[stream], first + many - 1)
        return {stream: (max(newest[stream] - n, 0), n) for stream, n in seen.items()}


Topics = dict[str, Series]
Events = list[dict[str, Any]]


def keep_own(topics: Topics) -> Events:
    """Remove from ``topics`` what is not the session's own; return that as events."""
    found: Events = []
    for topic, (kind, rows) in topics.items():
        problems = [misfit(kind.rpartition("/")[2], row.message) for row in rows]
        why = f"whose fields do not fit together ({next(filter(None, problems), '')})"
        found += _keep(topic, rows, [problem is None for problem in problems], why)
    for topic, epochs in _own_epochs(topics).items():
        rows = topics[topic].rows
        own = [int(row.message.epoch) in epochs for row in rows]
        found += _keep(topic, rows, own, "from another publisher")
    for topic, series in topics.items():
        found += _keep(topic, series.rows, _continuing(series), "out of sequence")
    return found


def _keep(topic: str, rows: list[Decoded], own: list[bool], why: str) -> Events:
    """Keep the messages of a topic for which ``own`` is true; return an event of the others."""
    if not (left_out := own.count(False)):
        return []
    first_ns = rows[own.index(False)].log_ns
    rows[:] = itertools.compress(rows, own)
    what = f"{count(left_out, 'message')} on {topic} {why}, left out"
    return [{"time_ns": first_ns, "who": topic, "kind": "stranger", "what": what}]


Spans = Mapping[int, tuple[int, int, int]]  # epoch: first and last log time [ns], messages


def _own_epochs(topics: Topics) -> dict[str, set[int]]:
    """Return the session's own epochs on every topic that carries one."""
    spans = {t: _spans(s.rows) for t, s in topics.items() if s.type_name in WITH_EPOCH}
    known: dict[str, set[int]] = {}  # by node: those of its packets, then of its trace
    for topic in spans:
        if topics[topic].type_name == schemas.WAVE:
            known[_sender(topic)] = {*known.get(_sender(topic), ()), *spans[topic]}
    own = {}
    for topic in sorted(spans, key=lambda each: topics[each].type_name not in TRACES):
        node = _sender(topic)
        own[topic] = _in_turn(spans[topic], known.get(node, set()))
        if topics[topic].type_name in TRACES:
            known[node] = own[topic]
        if topics[topic].type_name == schemas.RECEPTION and own[topic] & known.get(node, set()):
            ended_ns = max(spans[topic][epoch][1] for epoch in own[topic])  # no trace has it yet:
            own[topic] |= {epoch for epoch, span in spans[topic].items() if span[0] > ended_ns}
    return own


def _sender(topic: str) -> str:
    """Return the node that publishes on a topic, or whose packets it carries: ``server``, a user's
    name.
    """
    *_, owner, kind = ["", *topic.strip("/").split("/")]
    return "server" if kind == "wave_down" else owner


def _spans(rows: list[Decoded]) -> Spans:
    times: dict[int, list[int]] = defaultdict(list)
    for row in rows:
        times[int(row.message.epoch)].append(row.log_ns)
    return {epoch: (min(each), max(each), len(each)) for epoch, each in times.items()}


def _in_turn(spans: Spans, known: set[int]) -> set[int]:
    """Return the epochs that follow one another, those with most messages first."""
    candidates = {e: s for e, s in spans.items() if e in known} or spans
    accepted: dict[int, tuple[int, int, int]] = {}
    for epoch, (first, last, seen) in sorted(candidates.items(), key=lambda item: -item[1][2]):
        if all(last <= begin or first >= end for begin, end, _ in accepted.values()):
            accepted[epoch] = (first, last, seen)
    return set(accepted)


def _continuing(series: Series) -> list[bool]:
    """Tell which messages continue one another, publisher by publisher."""
    kind, rows_of_topic = series
    logs = np.array([row.log_ns for row in rows_of_topic], dtype=np.int64)
    numbers = np.array([row.first for row in rows_of_topic], dtype=np.int64)
    if kind == schemas.MASTER_TRACE:
        numbers = np.array([row.message.first_tick for row in rows_of_topic], dtype=np.int64)
    streams: dict[str, list[int]] = defaultdict(list)
    for place, row in enumerate(rows_of_topic):
        streams[row.stream].append(place)
    kept = np.zeros(len(numbers), dtype=bool)
    for stream in streams.values():
        rows = np.array(stream)
        rows = rows[np.argsort(numbers[rows], kind="stable")]
        if kind != schemas.WAVE:  # a link may deliver a packet twice
            rows = rows[np.diff(numbers[rows], prepend=-1) > 0]
        # the largest group of numbers without a jump that no loss explains
        cuts = np.flatnonzero(np.diff(numbers[rows]) > LARGEST_JUMP) + 1
        rows = max(np.split(rows, cuts), key=len)
        if kind in TRACES:
            starts = clocks.monotonic_times([rows_of_topic[row].message for row in rows])
            late = (logs[rows] - starts).astype(float)  # less so than its neighbours, or more
            after = np.diff(logs[rows], prepend=logs[rows[:1]], append=logs[rows[-1:]]) >= 0
            between = after[1:] & after[:-1]  # recorded between both: it stood still
            rows = rows[_as_neighbours(starts) & (_as_neighbours(late) | between)]
        kept[rows] = True
    return kept.tolist()


def _as_neighbours(times_ns: NDArray[Any]) -> Flags:
    """Tell which times are less than ``CLOCK_NS`` and a usual step off the median of five."""
    most_ns = CLOCK_NS + np.median(np.diff(times_ns, prepend=times_ns[:1]))
    fives = np.lib.stride_tricks.sliding_window_view(np.pad(times_ns, 2, mode="symmetric"), 5)
    return np.asarray(np.abs(times_ns - np.median(fives, axis=-1)) < most_ns)
