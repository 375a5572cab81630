# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers by name: the one place that knows both the wave controller and its rivals.

Whoever chooses a controller by name imports from here, so that all of them are there.
"""

from pmwvc_core.master.port import MASTERS, MasterController, make_master
from pmwvc_core.params import MasterParams
from pmwvc_core.rivals.direct import DirectMaster, DirectServer
from pmwvc_core.server.port import SERVERS, ServerController, make_server

__all__ = [
    "MASTERS",
    "SERVERS",
    "MasterController",
    "ServerController",
    "make_master",
    "make_server",
]


def _direct_master(params: MasterParams) -> MasterController:
    return DirectMaster(tick_s=params.tick_s)


MASTERS["direct"] = _direct_master
SERVERS["direct"] = DirectServer
