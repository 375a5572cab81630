# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers: one record per controller, found by its name."""

from pmwvc_core.controllers.ends import make_master, make_server
from pmwvc_core.controllers.library import (
    CHANNELS,
    LIBRARY,
    PLAIN,
    RECORDS,
    ZEROING,
    entries,
    has_waves,
    is_strict,
    is_zeroing,
    names,
    proofs_hold,
    record_of,
)
from pmwvc_core.controllers.record import HELD, Controller, Rule
from pmwvc_core.master.controller import MasterController
from pmwvc_core.server.controller import ServerController

__all__ = [
    "CHANNELS",
    "HELD",
    "LIBRARY",
    "PLAIN",
    "RECORDS",
    "ZEROING",
    "Controller",
    "MasterController",
    "Rule",
    "ServerController",
    "entries",
    "has_waves",
    "is_strict",
    "is_zeroing",
    "make_master",
    "make_server",
    "names",
    "proofs_hold",
    "record_of",
]
