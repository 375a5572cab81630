# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the controllers to compare with; both ends of a user's link share them."""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated


@dataclass(frozen=True)
class BaselineParams(Validated):
    """One group per controller that needs numbers of its own."""
