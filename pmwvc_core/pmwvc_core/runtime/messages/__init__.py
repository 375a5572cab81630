# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Building and reading messages: one conversion for live nodes and for recordings written without
ROS.

Every builder takes the message classes as its first argument: :func:`live_types` for rclpy,
:func:`types_from` for a typestore of rosbags. Nothing here judges what a message holds; a receiver
does.
"""

from pmwvc_core.runtime.messages.links import diagnostic, link_state, packet_fates, reception, wave
from pmwvc_core.runtime.messages.misfits import misfit
from pmwvc_core.runtime.messages.traces import master_trace, server_trace
from pmwvc_core.runtime.messages.types import (
    NS_PER_S,
    MessageTypes,
    live_types,
    nanoseconds,
    time_message,
    types_from,
)

__all__ = [
    "NS_PER_S",
    "MessageTypes",
    "diagnostic",
    "link_state",
    "live_types",
    "master_trace",
    "misfit",
    "nanoseconds",
    "packet_fates",
    "reception",
    "server_trace",
    "time_message",
    "types_from",
    "wave",
]
