# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole part of a damaged recording, written as a new session folder."""

import shutil
from pathlib import Path

from pmwvc_analysis.recording.content import WHOLE
from pmwvc_analysis.recording.format.topics import Topic
from pmwvc_analysis.recording.mcap.salvage import Salvage, messages
from pmwvc_analysis.recording.writer import SessionWriter
from pmwvc_core.errors import RecordingError, file_errors

COMPANIONS = ("scenario.yaml", "events.json", "nodes")


def recover(damaged: str | Path, target_folder: str | Path) -> Salvage:
    """Write what is whole in a damaged ``.mcap`` file as a new, complete session folder.

    The damaged file is left as it is. Topics keep their names, types, times and bytes.
    RecordingError where nothing can be read or written, or the new file does not read back whole.
    """
    salvage = Salvage()
    with SessionWriter(target_folder) as writer:
        for message in messages(damaged, salvage):
            writer.add_topic(
                Topic(message.topic, message.type_name, reliable=True, depth=10),
                schema=salvage.schemas[message.type_name],
            )
            writer.write(
                message.topic, message.data, log_ns=message.log_ns, publish_ns=message.publish_ns
            )
        for name, values in salvage.metadata.items():
            if name != "rosbag2":
                writer.add_metadata(name, values)
        end = salvage.end or WHOLE
        writer.add_metadata("recovered", {"from": Path(damaged).name, "cut": end})
    again = Salvage()
    count = sum(1 for _ in messages(writer.path, again))
    if writer.problem or again.end or count != salvage.messages:
        raise RecordingError(
            f"recovery of {damaged} failed: {count} of {salvage.messages} messages read back; "
            f"{writer.problem or again.end or 'the new file is incomplete'}"
        )
    return salvage


def mend(folder: str | Path, target: str | Path) -> str:
    """Recover a session folder (or one file) into a new one; return as text what was kept.

    Scenario, events and logs are copied. RecordingError where it holds not exactly one MCAP file,
    or the file cannot be recovered.
    """
    source, new = Path(folder), Path(target)
    files = sorted(source.glob("*.mcap")) if source.is_dir() else [source]
    if len(files) != 1:
        raise RecordingError(f"{source} holds {len(files)} .mcap files: name the one to mend")
    if new.exists() and (not new.is_dir() or any(new.iterdir())):
        raise RecordingError(f"{new} is not empty: a mended session needs a folder of its own")
    salvage = recover(files[0], new)
    with file_errors(f"write into {new}"):
        for name in COMPANIONS if source.is_dir() else ():
            if (source / name).is_dir():
                shutil.copytree(source / name, new / name)
            elif (source / name).is_file():
                shutil.copy2(source / name, new / name)
    why = salvage.end or "the file was whole"
    return f"{salvage.messages} messages of {files[0]} are in {new} ({why})"
