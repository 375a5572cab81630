# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The decoded messages of a recorded folder, of a damaged one as far as it is whole.

Message definitions come from the files themselves. What other programs published on the session's
topics is left out (own.py).

The targets of remote hands (``hand/target``, ``hand/held``) are as the master took them: ``held:
false`` lets go, and until ``held: true`` targets do not count. A message's time is that of its
publication, as long as it was received soon after (else the clocks may differ, and it is that of
its reception): the recorder may have to wait for the processor longer than the master.
"""

import contextlib
import itertools
from collections import ChainMap, Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import MCAP0_MAGIC as MAGIC

from pmwvc_analysis.recording.format import schemas
from pmwvc_analysis.recording.own import TopicMessages, Topics, keep_own
from pmwvc_analysis.recording.parameter_events import ParameterChange, parameter_change
from pmwvc_analysis.recording.salvage import RawMessage, Salvage, messages
from pmwvc_analysis.recording.sequence import GapCounter, peek
from pmwvc_core.errors import RecordingError, file_errors
from pmwvc_core.traces import HandTargets
from pmwvc_core.transport.packet import intact

CUT = "cut"  # kind of event: a file ends early
TRUSTED_NS = 500_000_000  # from publication to reception
NOWHERE: tuple[float, ...] = (np.nan, np.nan, np.nan)
Decode = Callable[[bytes, str], Any]


@dataclass
class Content:
    """Decoded messages by topic, and all other content of the files."""

    by_topic: Topics = field(default_factory=lambda: defaultdict(TopicMessages))
    types: dict[str, str] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    counter: GapCounter = field(default_factory=GapCounter)
    events: list[dict[str, Any]] = field(default_factory=list)
    parameters: list[ParameterChange] = field(default_factory=list)  # of any node
    hands: list[RawMessage] = field(default_factory=list)  # targets, and whether they count
    undecoded: Counter[tuple[str, str]] = field(default_factory=Counter)  # (topic, reason)

    def of_type(self, type_name: str) -> Topics:
        """Return the topics of one type that have messages."""
        found = (topic for topic, kind in self.types.items() if kind == type_name)
        return {topic: self.by_topic[topic] for topic in found if self.by_topic[topic].messages}

    def of_links(self, type_name: str) -> dict[str, list[Any]]:
        """Return the messages of one type by the name of their link."""
        found: dict[str, list[Any]] = defaultdict(list)
        for series in self.of_type(type_name).values():
            for message in series.messages:
                found[str(message.link)].append(message)
        return dict(sorted(found.items()))


def read_content(folder: Path) -> Content:
    """Return the decoded messages of every file; of a damaged one, as far as it is whole."""
    if not folder.exists():
        raise RecordingError(f"{folder} does not exist")
    files = [folder]
    if folder.is_dir():  # rosbag2 numbers the files of a folder, without leading zeros
        files = sorted(folder.glob("*.mcap"), key=lambda path: (len(path.name), path.name))
    if not files:
        return _of_other_files(folder)
    for path in files:
        with file_errors(f"read {path}"), open(path, "rb") as stream:
            begin = stream.read(len(MAGIC))
        if begin != MAGIC:
            what = "is not an MCAP file: its first bytes are not those of one"
            what = what if begin else "is empty"
            raise RecordingError(f"{path} {what}; name a session folder, or an .mcap file")
    salvages = {path: Salvage() for path in files}
    texts: ChainMap[str, str] = ChainMap(*(each.schemas for each in salvages.values()))
    content = content_of(
        itertools.chain.from_iterable(messages(path, each) for path, each in salvages.items()),
        lambda data, t: schemas.store_of((texts[t], t)).deserialize_cdr(data, t),
    )
    early = []
    for path, salvage in salvages.items():
        content.metadata.update(salvage.metadata)
        content.counter.messages = dict.fromkeys(salvage.topics, 0) | content.counter.messages
        if salvage.end:
            what = f"{path.name} ends early ({salvage.end}); everything before is read"
            early.append({"time_s": None, "who": "recorder", "kind": CUT, "what": what})
    content.events = early + content.events
    return content


def _of_other_files(folder: Path) -> Content:
    """Return the content of a folder that rosbag2 recorded into other files than MCAP; of its
    messages only the time of reception is known.
    """
    from rosbags.highlevel import AnyReader

    try:
        with AnyReader([folder]) as reader:
            raw = (
                RawMessage(connection.topic, connection.msgtype, log_ns, log_ns, bytes(data))
                for connection, log_ns, data in reader.messages()
            )
            content = content_of(raw, reader.deserialize)
            for connection in reader.connections:
                content.counter.topic(connection.topic)
            return content
    except Exception as error:  # rosbags raises many kinds for a damaged file
        reason = str(error) or type(error).__name__
    if not (folder / "metadata.yaml").exists():
        why = "neither an .mcap file nor a metadata.yaml is in it"
        other = "name a session folder, or one that rosbag2 recorded"
        raise RecordingError(f"{folder} holds no recording: {why}; {other}")
    raise RecordingError(f"{folder} holds no recording that can be read: {reason}")


def content_of(raw: Iterable[RawMessage], decode: Decode) -> Content:
    """Return the content of serialized messages; ``decode(data, type_name)`` returns a message.
    What is not the session's becomes events.
    """
    content = Content()
    for message in raw:
        _take(content, message, decode)
    content.events += keep_own(content.by_topic, content.types)
    for topic in content.types:
        for number in content.by_topic[topic].numbers:
            content.counter.add(topic, number)
    for (topic, reason), count in content.undecoded.items():
        amount = "a message" if count == 1 else f"{count} messages"
        what = f"{topic}: {amount} cannot be decoded ({reason})"
        content.events.append({"time_s": None, "who": "recorder", "what": what})
    return content


def _take(content: Content, raw: RawMessage, decode: Decode) -> None:
    if raw.type_name not in schemas.OUR_TYPES:
        content.counter.add(raw.topic, None)
        if raw.type_name == schemas.PARAMETER_EVENT and (change := parameter_change(raw.data)):
            content.parameters.append(change)
        if is_of_hand(raw):
            content.hands.append(raw)
        return
    content.counter.topic(raw.topic)
    if raw.type_name == schemas.WAVE and not intact(raw.data):
        return  # corrupted by a link: nothing in it is believed; the fates tell of it
    if (numbers := peek(raw.type_name, raw.data)) is None:
        content.undecoded[raw.topic, "too short"] += 1
        return
    try:
        message = decode(raw.data, raw.type_name)
    except Exception as error:  # a message that is no message: counted, reported, passed over
        content.undecoded[raw.topic, str(error) or type(error).__name__] += 1
        return
    content.types[raw.topic] = raw.type_name
    series = content.by_topic[raw.topic]
    series.log_ns.append(raw.log_ns)
    series.messages.append(message)
    series.numbers.append(numbers)


def is_of_hand(message: RawMessage) -> bool:
    """Tell whether a message is on one of the topics of a hand."""
    ends = {schemas.POINT: "/hand/target", schemas.FLAG: "/hand/held"}
    return message.topic.endswith(ends.get(message.type_name, "\0"))


def hand_targets(messages: Iterable[RawMessage], zero_ns: int) -> Mapping[str, HandTargets]:
    """Return the targets of every user that has any, by name."""
    found: dict[str, list[tuple[float, tuple[float, ...]]]] = {}
    counts: dict[str, bool] = {}
    for message in sorted(messages, key=_arrived_ns):
        user = message.topic.strip("/").split("/")[-3]
        point: tuple[float, ...] | None = None
        if message.type_name == schemas.FLAG:
            counts[user] = len(message.data) > 4 and bool(message.data[4])
            point = None if counts[user] else NOWHERE
        elif counts.get(user, True):
            with contextlib.suppress(Exception):  # no point: rosbags raises many kinds
                at = schemas.typestore().deserialize_cdr(message.data, schemas.POINT).point
                point = at.x, at.y, at.z
        if point is not None:
            time_s = (_arrived_ns(message) - zero_ns) * 1e-9
            found.setdefault(user, []).append((time_s, point))
    columns = {user: zip(*rows, strict=True) for user, rows in found.items()}
    return {user: HandTargets(*map(np.array, each)) for user, each in columns.items()}


def _arrived_ns(message: RawMessage) -> int:
    """Return when a message arrived at the master, as well as it is known [ns]."""
    waited = 0 <= message.log_ns - message.publish_ns < TRUSTED_NS
    return message.publish_ns if waited else message.log_ns
