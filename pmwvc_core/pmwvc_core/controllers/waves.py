# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of ``pmwvc``: wave variables both ways."""

from pmwvc_core.controllers.accounts import OF_WAVES
from pmwvc_core.controllers.record import Controller
from pmwvc_core.params import BaselineParams, MasterParams


def storage_j(master: MasterParams, baseline: BaselineParams) -> float:
    """Return what position feedback may spend before it is paid [J]; none as published."""
    position = master.position
    return float(position.storage_j) if position.is_paid else 0.0


RECORD = Controller(
    name="pmwvc",
    words="Wave variables: stable at any constant delay where the gains of both ends prove it.",
    waves=True,
    linear="pmwvc",
    drifts=True,
    storage_j=storage_j,
    accounts=OF_WAVES,
)
