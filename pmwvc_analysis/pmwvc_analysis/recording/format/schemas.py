# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Schema texts of ROS messages for MCAP (encoding ``ros2msg``), found without ROS.

A schema is the ``.msg`` text followed, for each type it uses (transitively, once), by a line of 80
``=``, a line ``MSG: package/Type`` and that type's ``.msg`` text. Our own messages come from the
source tree or from a share folder of an installed workspace; standard ones from a share folder or,
without ROS, from the tables that rosbags carries.
"""

import functools
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from pmwvc_core.errors import RecordingError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

WAVE = "pmwvc_msgs/msg/Wave"
MASTER_TRACE = "pmwvc_msgs/msg/MasterTrace"
SERVER_TRACE = "pmwvc_msgs/msg/ServerTrace"
LINK_STATE = "pmwvc_msgs/msg/LinkState"
PACKET_FATE = "pmwvc_msgs/msg/PacketFate"
RECEPTION = "pmwvc_msgs/msg/Reception"
PARAMETER_EVENT = "rcl_interfaces/msg/ParameterEvent"
POINT = "geometry_msgs/msg/PointStamped"
FLAG = "std_msgs/msg/Bool"
OUR_TYPES = (WAVE, MASTER_TRACE, SERVER_TRACE, LINK_STATE, PACKET_FATE, RECEPTION)

_SEPARATOR = "=" * 80


def _message_folders(package: str) -> Iterator[Path]:
    """Yield the folders that may hold the ``.msg`` files of a package, source tree first."""
    here = Path(__file__).resolve()
    yield here.parents[4] / package / "msg"
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix:
            yield Path(prefix) / "share" / package / "msg"
    for folder in (Path(sys.prefix), *here.parents):
        yield folder / "share" / package / "msg"


@functools.cache
def message_text(type_name: str) -> str:
    """Return the ``.msg`` text of a type (``pmwvc_msgs/msg/Wave``), or raise RecordingError."""
    package, _, name = type_name.replace("/msg/", "/").partition("/")
    for folder in _message_folders(package):
        path = folder / f"{name}.msg"
        if path.is_file():
            return path.read_text(encoding="utf-8")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    full = f"{package}/msg/{name}"
    if full in store.fielddefs:
        text: str = store.generate_msgdef(full, ros_version=2)[0]
        return text.split(_SEPARATOR)[0]
    raise RecordingError(
        f"no definition of message {type_name}: neither a source tree nor a share folder of a "
        "built workspace holds it; run 'make setup' or source the workspace"
    )


def used_types(type_name: str) -> list[str]:
    """Return the message types that the fields of a type have, as ``package/msg/Type``."""
    from rosbags.interfaces import Nodetype
    from rosbags.typesys import get_types_from_msg

    found = []
    for _, (kind, inner) in get_types_from_msg(message_text(type_name), type_name)[type_name][1]:
        while kind not in (Nodetype.BASE, Nodetype.NAME):  # of arrays, that of an element
            (kind, inner), _ = inner
        found += [str(inner)] if kind == Nodetype.NAME else []
    return found


@functools.cache
def schema_text(type_name: str) -> str:
    """Return the whole ``ros2msg`` schema of a type: its own text, then those it depends on."""
    parts = [message_text(type_name)]
    seen = {type_name}
    waiting = used_types(type_name)
    while waiting:
        dependency = waiting.pop(0)
        if dependency in seen:
            continue
        seen.add(dependency)
        parts.append(f"MSG: {dependency.replace('/msg/', '/')}\n{message_text(dependency)}")
        waiting += used_types(dependency)
    return f"{_SEPARATOR}\n".join(part if part.endswith("\n") else part + "\n" for part in parts)


@functools.cache
def typestore(*type_names: str) -> "Typestore":
    """Return a rosbags type store that knows these types (ours when none is named)."""
    return store_of(*((schema_text(name), name) for name in type_names or OUR_TYPES))


@functools.cache
def store_of(*types: tuple[str, str]) -> "Typestore":
    """Return a rosbags type store that knows types given by whole schema text and name."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    for schema, type_name in types:
        store.register(get_types_from_msg(schema, type_name))
    return store


def hash_of(schema: str, type_name: str) -> str:
    """Return the REP-2016 hash (``RIHS01_...``) of a type given by its whole schema text."""
    text: str = store_of((schema, type_name)).hash_rihs01(type_name)
    return text
