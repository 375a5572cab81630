# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Schema texts of ROS messages for MCAP (encoding ``ros2msg``), found without ROS.

A schema is the ``.msg`` text followed, for each type it uses (transitively, once), by a line of 80
``=``, a line ``MSG: package/Type`` and that type's ``.msg`` text. Our own messages come from the
source tree or from a share folder of an installed workspace, standard ones from the tables that
rosbags carries.
"""

import functools
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from pmwvc_core.errors import RecordingError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

WAVE = "pmwvc_msgs/msg/Wave"
MASTER_TRACE = "pmwvc_msgs/msg/MasterTrace"
SERVER_TRACE = "pmwvc_msgs/msg/ServerTrace"
PACKET_FATE = "pmwvc_msgs/msg/PacketFate"
RECEPTION = "pmwvc_msgs/msg/Reception"
PARAMETER_EVENT = "rcl_interfaces/msg/ParameterEvent"
POSE = "geometry_msgs/msg/PoseStamped"
FLAG = "std_msgs/msg/Bool"
TEXT = "std_msgs/msg/String"
MARKERS = "visualization_msgs/msg/MarkerArray"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
OUR_TYPES = (WAVE, MASTER_TRACE, SERVER_TRACE, PACKET_FATE, RECEPTION)

_SEPARATOR = "=" * 80


def shares(here: Path) -> list[Path]:
    """Return the share folders of workspaces, of this environment, and of where a file is."""
    prefixes = [each for each in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if each]
    return [Path(each, "share") for each in (*prefixes, sys.prefix, *map(str, here.parents))]


def _own_text(type_name: str) -> str:
    """Return the ``.msg`` text of one of our types from the source tree, else a share folder."""
    here = Path(__file__).resolve()
    package, name = type_name.split("/msg/")
    for folder in (here.parents[3], *shares(here)):
        if (path := folder / package / "msg" / f"{name}.msg").is_file():
            return path.read_text(encoding="utf-8")
    why = "neither a source tree nor a share folder of a built workspace holds it"
    remedy = "run 'make setup' or source the workspace"
    raise RecordingError(f"no definition of message {type_name}: {why}; {remedy}")


@functools.cache
def typestore() -> "Typestore":
    """Return a rosbags type store that knows our types and the standard ones."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    for name in OUR_TYPES:
        store.register(get_types_from_msg(_own_text(name), name))
    return store


@functools.cache
def schema_text(type_name: str) -> str:
    """Return the whole ``ros2msg`` schema of a type: its own text, then those it depends on;
    RecordingError where it is not known.
    """
    if type_name not in typestore().fielddefs:
        return _own_text(type_name)
    text: str = typestore().generate_msgdef(type_name, ros_version=2)[0]
    if type_name in OUR_TYPES:  # with its comments
        text = "".join([_own_text(type_name), *text.partition(_SEPARATOR)[1:]])
    return text


@functools.cache
def store_of(*types: tuple[str, str]) -> "Typestore":
    """Return a rosbags type store that knows types given by whole schema text and name."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    for schema, type_name in types:
        store.register(get_types_from_msg(schema, type_name))
    return store
