# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorded folder as :class:`SessionTraces`, without ROS.

Ours, one that rosbag2 recorded with the same topics, and what a killed recorder left are read
alike. Message definitions come from the file itself.
"""

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.recording import assemble
from pmwvc_analysis.recording.clocks import clock
from pmwvc_analysis.recording.clocks.time_lines import time_lines
from pmwvc_analysis.recording.content import Content, read_content
from pmwvc_analysis.recording.format import schemas
from pmwvc_analysis.recording.format.topics import source_of
from pmwvc_analysis.recording.losses import not_relayed, topic_counts
from pmwvc_analysis.recording.parameter_events import parameter_changes
from pmwvc_core.errors import RecordingError
from pmwvc_core.runtime.messages import nanoseconds
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import FateTraces, ServerTraces, SessionTraces, UserTraces


def read_session(folder: str | Path) -> SessionTraces:
    """Return everything recorded in a folder.

    Raises
    ------
    RecordingError
        If there is no recording, or nothing of it can be read.
    """
    return session_of(read_content(Path(folder)), Path(folder))


def session_of(content: Content, folder: Path) -> SessionTraces:
    """Return decoded messages as traces; ``folder`` may hold what the runner noted.

    Raises
    ------
    RecordingError
        If no message is of a session.
    """
    masters = {
        topic.strip("/").rpartition("/")[0]: seen
        for topic, seen in content.of_type(schemas.MASTER_TRACE).items()
    }
    servers = [each for seen in content.of_type(schemas.SERVER_TRACE).values() for each in seen]
    fates = _fates(content)
    times = time_lines(content.by_topic, masters, servers, fates)
    starts = times.masters
    first = [int(each.min()) for each in starts.values()]
    if servers:
        first.append(int(times.server.min()))
    logs = [log_ns for seen in content.by_topic.values() for log_ns, _ in seen]
    if not logs:
        raise RecordingError(_nothing(folder, content))
    zero_ns = clock.first(first or logs)
    users = [
        assemble.user_traces(name, [message for _, message in seen], starts[name], zero_ns=zero_ns)
        for name, seen in sorted(masters.items())
    ]
    server, lateness = (
        assemble.server_traces([step for _, step in servers], times.server, zero_ns=zero_ns)
        if servers
        else (None, np.zeros(0))
    )
    traces = SessionTraces(
        source=content.metadata.get("session", {}).get("source", "live"),
        duration_s=_duration(users, server, logs, zero_ns),
        users=users,
        server=server,
        metadata={
            **content.metadata,
            "zero_ns": zero_ns,
            "server_lateness_s": lateness,
            "alignment": times.alignment,
        },
        fates=fates,
    )
    _add_network(traces, content, zero_ns)
    traces.counts = topic_counts(content.counter, traces.fates, traces.packets)
    traces.events = _events(folder, content, zero_ns) + _start_losses(traces)
    return traces


def _nothing(folder: Path, content: Content) -> str:
    """Say why a recording that could be opened holds nothing of a session, and what it holds."""
    others = [topic for topic, count in content.counter.messages.items() if count]
    reasons = [str(event["what"]) for event in content.events]
    if others:
        shown = ", ".join(others[:4]) + (", ..." if len(others) > 4 else "")
        why = f"it has {shown}; a session has /server/trace and /trace of every user"
    else:
        why = "; ".join(reasons) or "nothing was recorded"
    if (folder / "nodes").is_dir():
        why += f"; logs of its nodes: {folder / 'nodes'}"
    return f"{folder} holds no message of a session: {why}"


def read_scenario(folder: str | Path) -> Scenario | None:
    """Return the scenario of a session folder, or None where the folder holds none."""
    path = Path(folder) / "scenario.yaml"
    if not path.is_file():
        return None
    import yaml

    from pmwvc_core.scenario.reader import parse_scenario

    return parse_scenario(yaml.safe_load(path.read_text(encoding="utf-8")), source=str(path))


def _add_network(traces: SessionTraces, content: Content, zero_ns: int) -> None:
    """Fill in packets, fates and link states."""
    for topic, seen in content.of_type(schemas.WAVE).items():
        traces.packets[topic] = assemble.packet_traces(
            topic,
            [message for _, message in seen],
            [log_ns for log_ns, _ in seen],
            zero_ns=zero_ns,
        )
    zeros: dict[str, int] = {}
    for link, messages in _of_links(content, schemas.PACKET_FATE).items():
        last_in = np.array(
            [int(np.max(m.time_in_ns)) for m in messages if len(m.time_in_ns)], dtype=np.int64
        )
        stamps = np.array(
            [nanoseconds(m.stamp) for m in messages if len(m.time_in_ns)], dtype=np.int64
        )
        if len(last_in):
            # a block is published after its last packet came in: the least difference is the
            # clocks'
            zeros[link] = zero_ns - int(np.min(stamps - last_in))
    traces.metadata["fate_zero_ns"] = zeros
    traces.link_states = {
        link: assemble.link_states(messages, zero_ns=zero_ns)
        for link, messages in _of_links(content, schemas.LINK_STATE).items()
    }


def _fates(content: Content) -> dict[str, FateTraces]:
    return {
        link: assemble.fate_traces(link, messages)
        for link, messages in _of_links(content, schemas.PACKET_FATE).items()
    }


def _of_links(content: Content, type_name: str) -> dict[str, list[Any]]:
    """Return the messages of one type by the name of their link."""
    found: dict[str, list[Any]] = defaultdict(list)
    for seen in content.of_type(type_name).values():
        for _, message in seen:
            found[str(message.link)].append(message)
    return dict(sorted(found.items()))


def _duration(
    users: list[UserTraces], server: ServerTraces | None, logs: list[int], zero_ns: int
) -> float:
    """Return the time from the first tick or step to the end of the last tick of a user.

    The server runs on a little after the users have left; that is not part of the session.
    """
    ends = [float(user.time_s[-1]) + user.tick_s for user in users if len(user.time_s)]
    if server is not None and not ends:
        ends.append(float(server.time_s[-1]) + server.period_s)
    return max(ends, default=(max(logs) - min(logs)) * 1e-9)


def _events(folder: Path, content: Content, zero_ns: int) -> list[dict[str, Any]]:
    """Return what reading found and what the runner noted (``events.json``)."""
    found = content.events + parameter_changes(content.parameters, folder, zero_ns)
    if (mended := content.metadata.get("recovered")) is not None:
        what = f"mended from {mended.get('from')}: {mended.get('cut')}"
        found.append({"time_s": None, "who": "recorder", "kind": "recording", "what": what})
    path = folder / "events.json"
    if path.is_file():
        try:
            found += json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            found.append(
                {"time_s": None, "who": "runner", "what": f"events.json cannot be read: {error}"}
            )
    for event in found:
        if "time_ns" in event:
            event["time_s"] = (int(event.pop("time_ns")) - zero_ns) * 1e-9
        event.setdefault("time_s", None)
    return found


def _start_losses(traces: SessionTraces) -> list[dict[str, Any]]:
    """Return as events which packets never reached their link."""
    found: list[dict[str, Any]] = []
    for link, fates in traces.fates.items():
        packets = traces.packets.get(source_of(link))
        if packets is None or not len(fates.seq):
            continue
        count, first = not_relayed(packets, fates)
        if count:
            time_s = float(packets.time_s[np.argmax(packets.seq == first)])
            what = f"{count} packets of {packets.topic} never reached it, from number {first} on"
            found.append({"time_s": time_s, "who": link, "kind": "link", "what": what})
    return found
