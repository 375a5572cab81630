# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the server that change in flight, before a step; no energy comes or goes."""

from typing import Any

from pmwvc_core.law.server.body import changed_body
from pmwvc_core.law.server.server_port import Environment
from pmwvc_core.law.server_step import ServerStepParams


def changed_server(s: Environment, p: ServerStepParams, q: ServerStepParams) -> Environment:
    """Go on with other parameters of object and coupling, from forces and velocities as they are.

    ``p`` are the parameters until here, ``q`` those from here on. A black box keeps its own.
    """
    old: Any = p.environment
    if not hasattr(s.body, "environment"):
        return s._replace(body=changed_body(s.body, old.body, q.environment.body))
    return s
