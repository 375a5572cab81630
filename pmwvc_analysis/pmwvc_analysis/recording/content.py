# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The decoded messages of a recorded folder, of a damaged one as far as it is whole.

Message definitions come from the files themselves. What other programs published on the session's
topics is left out (own.py).

The targets of remote hands (``hand/target``, ``hand/held``) are as the master took them: ``held:
false`` lets go, and until ``held: true`` targets do not count.
"""

import contextlib
import itertools
import json
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import astuple, dataclass, field
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import MCAP0_MAGIC as MAGIC

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.clocks import trusted_times
from pmwvc_analysis.recording.own import Series, Topics, decoded, keep_own
from pmwvc_analysis.recording.parameter_events import ParameterChange, parameter_change
from pmwvc_analysis.recording.salvage import RawMessage, Salvage, messages
from pmwvc_analysis.recording.topics import HAND, SCENE
from pmwvc_core.errors import RecordingError, file_errors
from pmwvc_core.numeric import Array
from pmwvc_core.quaternions import IDENTITY, Orientation, unit
from pmwvc_core.traces import HandTargets
from pmwvc_core.transport.packet import intact
from pmwvc_core.words import count

LATEST_NS = 1 << 62  # log times beyond overflow
CUT = "cut"  # kind of event: a file ends early
NOWHERE: tuple[float, ...] = (np.nan, np.nan, np.nan)
Decode = Callable[[bytes, str], Any]


@dataclass
class Content:
    """Decoded messages by topic, and all other content of the ``files``, by their names."""

    topics: Topics = field(default_factory=dict)
    files: dict[str, Salvage] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    messages: Counter[str] = field(default_factory=Counter)  # by topic, also of other programs
    events: list[dict[str, Any]] = field(default_factory=list)
    parameters: list[ParameterChange] = field(default_factory=list)  # of any node
    # targets of hands, and whether they count, by topic
    hands: dict[str, list[RawMessage]] = field(default_factory=lambda: defaultdict(list))
    scene: dict[str, Any] = field(default_factory=dict)  # the first description of one

    def of_type(self, type_name: str) -> Topics:
        """Return the topics of one type that have messages, sorted by name."""
        found = sorted((name, each) for name, each in self.topics.items() if each.rows)
        return {name: each for name, each in found if each.type_name == type_name}

    def gaps(self, topic: str) -> dict[str, tuple[int, int]]:
        """Return how many numbers of each publisher of a topic are missing, and how many came."""
        return self.topics[topic].gaps() if topic in self.topics else {}

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
    paths = [folder]
    if folder.is_dir():  # rosbag2 numbers the files of a folder, without leading zeros
        paths = sorted(folder.glob("*.mcap"), key=lambda path: (len(path.name), path.name))
    if not paths:
        other = "name a session folder; 'ros2 bag convert' makes an .mcap file of other recordings"
        raise RecordingError(f"{folder} holds no recording: no .mcap file is in it; {other}")
    for path in paths:
        with file_errors(f"read {path}"), open(path, "rb") as stream:
            begin = stream.read(len(MAGIC))
        if begin != MAGIC:
            what = "is not an MCAP file: its first bytes are not those of one"
            what = what if begin else "is empty"
            raise RecordingError(f"{path} {what}; name a session folder, or an .mcap file")
    files = {path: Salvage() for path in paths}

    def decode(data: bytes, kind: str) -> Any:
        text = next(file.schemas[kind] for file in files.values() if kind in file.schemas)
        return schemas.store_of((text, kind)).deserialize_cdr(data, kind)

    each = (messages(path.open("rb"), file) for path, file in files.items())
    content = content_of(itertools.chain.from_iterable(each), decode)
    for path, file in files.items():
        content.files[path.name] = file
        content.metadata.update(file.metadata)
        for topic in file.topics:
            content.messages[topic] += 0  # counted also where nothing came
        if file.end:
            what = f"{path.name} ends early ({file.end}); everything before is read"
            content.events.insert(0, {"who": "recorder", "kind": CUT, "what": what})
    return content


def content_of(raw: Iterable[RawMessage], decode: Decode) -> Content:
    """Return the content of serialized messages; ``decode(data, type_name)`` returns a message.
    What is not the session's becomes events.
    """
    content = Content()
    undecoded: Counter[tuple[str, str]] = Counter()  # topic, reason
    for message in raw:
        if problem := _take(content, message, decode):
            undecoded[message.topic, problem] += 1
    content.events += keep_own(content.topics)
    for topic, series in content.topics.items():
        content.messages[topic] = len(series.rows)
    for (topic, reason), number in undecoded.items():
        what = f"{topic}: {count(number, 'message')} cannot be decoded ({reason})"
        content.events.append({"who": "recorder", "kind": "recording", "what": what})
    return content


def _take(content: Content, raw: RawMessage, decode: Decode) -> str | None:
    """Take a message in; return why it cannot be decoded."""
    if raw.log_ns >= LATEST_NS:
        return f"recorded at {raw.log_ns} ns"
    if raw.type_name not in schemas.OUR_TYPES:
        content.messages[raw.topic] += 1
        if raw.type_name == schemas.PARAMETER_EVENT and (change := parameter_change(raw.data)):
            content.parameters.append(change)
        if is_of_hand(raw):
            content.hands[raw.topic].append(raw)
        if raw.topic == SCENE and not content.scene:
            with contextlib.suppress(Exception):  # no such text: rosbags raises many kinds
                text = schemas.typestore().deserialize_cdr(raw.data, schemas.TEXT).data
                content.scene = dict(json.loads(text))
        return None
    content.messages[raw.topic] += 0
    if raw.type_name == schemas.WAVE and not intact(raw.data):
        return None  # corrupted by a link: nothing in it is believed; the fates tell of it
    try:
        message = decode(raw.data, raw.type_name)
    except Exception as error:  # a message that is no message: counted, reported, passed over
        return str(error) or type(error).__name__
    series = content.topics.setdefault(raw.topic, Series(raw.type_name, []))
    series.rows.append(decoded(raw, message))
    return None


def is_of_hand(message: RawMessage) -> bool:
    """Tell whether a message is on one of the topics of a hand."""
    end = HAND.get(message.type_name)
    return end is not None and message.topic.endswith(f"/{end}")


def hand_targets(
    topics: Mapping[str, list[RawMessage]], zero_ns: int
) -> Mapping[str, HandTargets]:
    """Return the targets of every user that has any, by name."""
    found: dict[str, list[tuple[float, tuple[float, ...], Orientation]]] = {}
    counts: dict[str, bool] = {}
    timed: list[tuple[int, RawMessage]] = []
    for each in topics.values():
        published, recorded = [raw.publish_ns for raw in each], [raw.log_ns for raw in each]
        timed += zip(trusted_times(published, recorded).tolist(), each, strict=True)
    for at_ns, message in sorted(timed, key=itemgetter(0)):
        user = message.topic.strip("/").split("/")[-3]
        point: tuple[float, ...] | None = None
        q = found[user][-1][2] if user in found else IDENTITY
        if message.type_name == schemas.FLAG:
            counts[user] = any(message.data[4:5])
            point = None if counts[user] else NOWHERE
        elif counts.get(user, True):
            with contextlib.suppress(Exception):  # no pose: rosbags raises many kinds
                place = schemas.typestore().deserialize_cdr(message.data, schemas.POSE).pose
                point = place.position.x, place.position.y, place.position.z
                q = unit(astuple(place.orientation)[:4], q) or q
        if point is not None:
            found.setdefault(user, []).append(((at_ns - zero_ns) * 1e-9, point, q))
    columns = {user: map(np.array, zip(*rows, strict=True)) for user, rows in found.items()}
    return {u: HandTargets(t, x, sum_of_turns(q)) for u, (t, x, q) in columns.items()}


def sum_of_turns(q: Array) -> Array:
    """Return the turns since the identity, added up, for orientations ``(row, 4)`` [rad]."""
    from scipy.spatial.transform import Rotation  # takes long to import, and only this needs it

    every = Rotation.from_quat(np.vstack([IDENTITY, q]))
    return np.cumsum((every[1:] * every[:-1].inv()).as_rotvec(), axis=0)
