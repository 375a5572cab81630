# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The messages of a recording, read and written again with changes."""

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.salvage import Salvage, messages
from pmwvc_analysis.recording.topics import Topic
from pmwvc_analysis.recording.writer import SessionWriter


def raw(folder):
    """Every message of a folder, in order."""
    return list(messages(folder / "session.mcap", Salvage()))


def rewritten(found, folder, change=lambda kind, message: message):
    """Write messages into a new folder, each passed through ``change`` (None: left out)."""
    store = schemas.typestore()
    with SessionWriter(folder) as writer:
        for message in found:
            content = change(message.topic, store.deserialize_cdr(message.data, message.type_name))
            if content is not None:
                writer.add_topic(Topic(message.topic, message.type_name, True, 10))
                data = bytes(store.serialize_cdr(content, message.type_name))
                writer.write(message.topic, data, log_ns=message.log_ns)
    return folder
