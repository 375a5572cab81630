# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's end of the channel: wave port, port filters, safety limits."""

from pmwvc_core.master.controller import MasterController
from pmwvc_core.master.port import WaveMaster
from pmwvc_core.master.safety.limiter import SafetyLimiter, SafetyState

__all__ = [
    "MasterController",
    "SafetyLimiter",
    "SafetyState",
    "WaveMaster",
]
