# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The messages of a recording, read and written again with changes; traces compared."""

import dataclasses

import numpy as np

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.salvage import Salvage, messages
from pmwvc_analysis.recording.topics import Topic
from pmwvc_analysis.recording.writer import SessionWriter


def raw(folder):
    """Every message of a folder, in order."""
    return list(messages((folder / "session.mcap").open("rb"), Salvage()))


def written(found, folder):
    """Write messages into a new session folder, in their order."""
    with SessionWriter(folder) as writer:
        for message in found:
            if message.topic not in writer.messages:
                writer.add_topic(Topic(message.topic, message.type_name, depth=10))
            times = {"log_ns": message.log_ns, "publish_ns": message.publish_ns}
            writer.write(message.topic, message.data, **times)
    return folder


def rewritten(found, folder, change=lambda topic, message: message):
    """Write messages into a new folder, each passed through ``change`` (None: left out)."""
    store, kept = schemas.typestore(), []
    for message in found:
        content = change(message.topic, store.deserialize_cdr(message.data, message.type_name))
        if content is not None:
            data = bytes(store.serialize_cdr(content, message.type_name))
            kept.append(message._replace(data=data))
    return written(kept, folder)


def unequal(left, right, where=""):
    """Yield where two traces differ: to the last bit, times to 1e-15 s, lateness as a float32."""
    if dataclasses.is_dataclass(left):
        left, right = vars(left), vars(right)
    if isinstance(left, dict):
        if left.keys() != right.keys():
            yield where
        for name in left.keys() & right.keys():
            yield from unequal(left[name], right[name], f"{where}.{name}")
    elif isinstance(left, list) and len(left) == len(right):
        for place, (one, other) in enumerate(zip(left, right, strict=True)):
            yield from unequal(one, other, f"{where}.{place}")
    elif isinstance(left, np.ndarray) and left.dtype.kind == "f" and left.shape == right.shape:
        name = where.rpartition(".")[2]
        most = 2e-15 if "time_s" in name else 1e-9 if name == "lateness_s" else 0.0
        if np.nanmax(np.abs(left - right), initial=0.0) > most:
            yield where
    elif not np.array_equal(left, right):
        yield where
