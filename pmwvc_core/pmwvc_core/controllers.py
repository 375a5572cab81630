# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers by name: the one place that knows both the wave controller and its rivals."""

from pmwvc_core.rivals.direct import DirectServer
from pmwvc_core.server.port import SERVERS, ServerController, make_server

__all__ = ["SERVERS", "ServerController", "make_server"]

SERVERS["direct"] = DirectServer
