# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A recorded folder as :class:`SessionTraces`, without ROS.

Ours, one that rosbag2 recorded with the same topics, and what a killed recorder left are read
alike. Message definitions come from the file itself.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from pmwvc_analysis.recording import assemble, links, schemas
from pmwvc_analysis.recording.clocks import time_lines
from pmwvc_analysis.recording.content import Content, hand_targets, read_content
from pmwvc_analysis.recording.parameter_events import parameter_changes, taken_over
from pmwvc_analysis.recording.scenario_file import mapping_in
from pmwvc_core.controllers.library import PLAIN
from pmwvc_core.errors import RecordingError
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces


def read_session(folder: str | Path) -> SessionTraces:
    """Return everything recorded in a folder; RecordingError where nothing can be read."""
    return session_of(read_content(Path(folder)), Path(folder))


def session_of(content: Content, folder: Path) -> SessionTraces:
    """Return decoded messages as traces; ``folder`` may hold the runner's notes. RecordingError
    where no message is of a session.
    """
    logs = [row.log_ns for series in content.topics.values() for row in series.rows]
    if not logs:
        raise RecordingError(_nothing(folder, content))
    masters = {
        topic.strip("/").rpartition("/")[0]: series.messages
        for topic, series in content.of_type(schemas.MASTER_TRACE).items()
    }
    rows = [row for each in content.of_type(schemas.SERVER_TRACE).values() for row in each.rows]
    steps, steps_log_ns = [row.message for row in rows], [row.log_ns for row in rows]
    waves, reports = content.of_type(schemas.WAVE), content.of_links(schemas.RECEPTION)
    fate_messages = content.of_links(schemas.PACKET_FATE)
    fates = {link: links.fate_traces(link, each) for link, each in fate_messages.items()}
    packets = {topic: series.messages for topic, series in waves.items()}
    times, server_ns, alignment = time_lines(masters, steps, steps_log_ns, packets, fates)
    zero_ns = min([int(each.min()) for each in (*times.values(), server_ns) if len(each)] or logs)
    about: dict[str, Any] = {"zero_ns": zero_ns, "alignment": alignment}
    about["fate_zero_ns"] = links.fate_zeros(fate_messages, zero_ns)
    traces = SessionTraces(
        source=content.metadata.get("session", {}).get("source", "live"),
        duration_s=(max(logs) - min(logs)) * 1e-9,
        users=[],
        server=None,
        packets={
            topic: assemble.packet_traces(topic, series.rows, zero_ns=zero_ns)
            for topic, series in waves.items()
        },
        fates=fates,
        receptions={link: links.reception_traces(link, each) for link, each in reports.items()},
        targets=dict(hand_targets(content.hands, zero_ns)),
        metadata={**content.metadata, "server_lateness_s": np.zeros(0), **about},
    )
    # To the end of the last tick of a user: the server runs on a little after the users have left.
    ends = []
    if steps:
        server, late_s, taken = assemble.server_traces(steps, server_ns, zero_ns=zero_ns)
        traces.server, traces.metadata["server_lateness_s"] = server, late_s
        server.scene = content.scene
        traces.taken = {f"{name}/up": packets for name, packets in taken.items()}
        ends = [] if masters else [float(server.time_s[-1]) + server.period_s]
    for name, blocks in masters.items():
        user, own = assemble.user_traces(name, blocks, times[name], zero_ns=zero_ns)
        traces.users.append(user)
        traces.taken[f"{name}/down"] = own
        ends.append(float(user.time_s[-1]) + user.tick_s)
    traces.duration_s = max(ends, default=traces.duration_s)
    traces.counts = links.topic_counts(content, fates, traces.packets)
    changed, changes = parameter_changes(content.parameters, zero_ns)
    traces.settings = taken_over(changes, traces.users, traces.server)
    traces.events = _events(folder, content, changed, zero_ns)
    return traces


def _nothing(folder: Path, content: Content) -> str:
    """Return why a recording that was opened holds nothing of a session, and what it holds."""
    others = [topic for topic, count in content.messages.items() if count]
    why = "; ".join(str(event["what"]) for event in content.events) or "nothing was recorded"
    if others:
        shown = ", ".join(others[:4]) + (", ..." if len(others) > 4 else "")
        why = f"it has {shown}; a session has /server/trace and /trace of every user"
    if (folder / "nodes").is_dir():
        why += f"; logs of its nodes: {folder / 'nodes'}"
    return f"{folder} holds no message of a session: {why}"


def read_scenario(folder: str | Path) -> Scenario | None:
    """Return the scenario of a session folder, or None where the folder holds none; ScenarioError
    where it is no scenario.

    One without ``channel`` is from before there was a choice: the plain channel.
    """
    path = Path(folder) / "scenario.yaml"
    if not path.is_file():
        return None
    return parse_scenario({"channel": PLAIN, **mapping_in(path)}, source=str(path))


def _events(
    folder: Path, content: Content, changed: list[dict[str, Any]], zero_ns: int
) -> list[dict[str, Any]]:
    """Return the findings of reading and the notes of the runner (``events.json``)."""
    found = content.events + changed
    path = folder / "events.json"
    if path.is_file():
        try:
            found += json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            what = f"events.json cannot be read: {error}"
            found.append({"who": "runner", "kind": "recording", "what": what})
    for event in found:
        if "time_ns" in event:
            event["time_s"] = (int(event.pop("time_ns")) - zero_ns) * 1e-9
        event.setdefault("time_s", None)
        event.setdefault("kind", "ended")  # as runners of before noted it
    return found
