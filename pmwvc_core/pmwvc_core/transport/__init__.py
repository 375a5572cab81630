# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Packets between the two ends: format, sender, receiver."""

from pmwvc_core.transport.packet import (
    FLAG_DIRECT,
    FLAG_LEAVING,
    FLAG_LIMITED,
    Packer,
    WavePacket,
    size_bytes,
)
from pmwvc_core.transport.receiver import Receiver
from pmwvc_core.transport.verdict import Verdict

__all__ = [
    "FLAG_DIRECT",
    "FLAG_LEAVING",
    "FLAG_LIMITED",
    "Packer",
    "Receiver",
    "Verdict",
    "WavePacket",
    "size_bytes",
]
