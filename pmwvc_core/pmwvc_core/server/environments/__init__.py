# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Environments by name: one record per environment, and black boxes of other packages."""

from pmwvc_core.server.environments.library import (
    LIBRARY,
    PLUGINS,
    environment_of,
    make_black_box,
    make_body,
    require,
)
from pmwvc_core.server.environments.record import Environment

__all__ = [
    "LIBRARY",
    "PLUGINS",
    "Environment",
    "environment_of",
    "make_black_box",
    "make_body",
    "require",
]
