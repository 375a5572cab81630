# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity filter by feeding back the high-pass part of the outgoing wave (App. D)."""

from typing import Any

from pmwvc_core.params import MasterParams


def make_velocity_filter(params: MasterParams) -> Any:
    """Return the filter as a part of the wave port, or None where there is none."""
    return None
