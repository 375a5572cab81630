# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the ends of a session are made for, without a scenario."""

from types import SimpleNamespace

from pmwvc_core.params import ServerParams, TaskParams
from pmwvc_core.params.user import ServerTimes


def session_given(**said):
    """Return a session of one axis on the plain channel, but for what is said."""
    every = {
        "controller": "pmwvc",
        "channel": "plain",
        "dof": 1,
        "users": (),
        "server": ServerParams(),
        "task": TaskParams(),
        "own": None,
        "times": ServerTimes(timeout_s=0.03, release_s=1.0, soft_start_s=0.5),
    }
    return SimpleNamespace(**every | said)
