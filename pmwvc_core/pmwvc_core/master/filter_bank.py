# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Filter bank with a local model on the high-pass part of the outgoing wave (App. E)."""

from typing import Any

from pmwvc_core.params import MasterParams


def make_bank(params: MasterParams) -> Any:
    """Return the bank as a part of the wave port, or None where there is none."""
    return None
