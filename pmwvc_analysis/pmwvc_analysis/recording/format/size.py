# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The disk space of a live session, from the sizes and rates of its messages."""

from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.transport.packet import size_bytes

COMPRESSED = 0.45  # of the bytes: measured over live sessions of two users
_RECORD = 47  # bytes around a message: its record and its entry in the index
_LINK_BYTES_S = 4 * (196 + _RECORD) + 10 * (60 + _RECORD)  # states, and heads of fate blocks
_PEOPLE_BYTES_S = 31 * (1500 + _RECORD)  # markers
_HEALTH_BYTES_S = 1000 + _RECORD  # diagnostics of one node


def live_bytes_per_minute(scenario: Scenario) -> float:
    """Return what the recording of a live session takes on disk a minute [byte]."""
    steps_hz = 1.0 / scenario.server.period_s
    raw = steps_hz * server_trace_bytes(scenario) + _PEOPLE_BYTES_S + 3 * _HEALTH_BYTES_S
    for user in scenario.users:
        frames_hz = 1.0 / user.master.frame_s
        packets_hz = frames_hz + steps_hz
        raw += frames_hz * master_trace_bytes(user, scenario.dof)
        raw += packets_hz * (2 * wave_bytes(scenario.dof) + 42)  # either end of a link, its fate
        raw += 2 * _LINK_BYTES_S + _HEALTH_BYTES_S
    return 60.0 * COMPRESSED * raw


def master_trace_bytes(user: User, dof: int) -> float:
    """Return what one block of ticks takes in the file before compression [byte]."""
    ticks = user.master.rate_drop
    return 212 + ticks * (8 * 8 * dof + 2 * 4) + _RECORD


def server_trace_bytes(scenario: Scenario) -> float:
    """Return what one step of the server takes in the file before compression [byte]."""
    per_user = 5 * 8 * scenario.dof + 30
    return 184 + 24 * scenario.dof + len(scenario.users) * per_user + _RECORD


def wave_bytes(dof: int) -> float:
    """Return what one packet takes in the file before compression [byte]."""
    return size_bytes(dof) + _RECORD
