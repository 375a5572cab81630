# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The client end: wave port, safety limits, and both in one object with receiver and sender."""

from pmwvc_core.master.client import Client
from pmwvc_core.master.controller import MasterController
from pmwvc_core.master.port import WaveMaster
from pmwvc_core.master.safety import SafetyLimiter, SafetyState

__all__ = [
    "Client",
    "MasterController",
    "SafetyLimiter",
    "SafetyState",
    "WaveMaster",
]
