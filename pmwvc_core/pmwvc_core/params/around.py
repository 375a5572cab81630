# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of what stands around the wave port of a master: velocity filter (App. D), filter
bank with local model (App. E), position feedback.
"""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated, parameter

VELOCITY_FILTERS = ("none", "equivalent", "exact")
BANKS = ("none", "dissertation", "complementary")
POSITION_FEEDBACKS = ("none", "printed", "budgeted", "integral")


@dataclass(frozen=True)
class VelocityFilterParams(Validated):
    """Velocity filter by feeding back the high-pass part of the outgoing wave (App. D)."""

    kind: str = parameter("none", "-", "which form", choices=VELOCITY_FILTERS, read_only=True)


@dataclass(frozen=True)
class BankParams(Validated):
    """Filter bank with a local model on its high-pass wave (App. E)."""

    kind: str = parameter("none", "-", "which bank", choices=BANKS, read_only=True)


@dataclass(frozen=True)
class PositionParams(Validated):
    """Position feedback on the returning wave, v_m - K_p (x_m - x_s) (App. E, Eq. 3)."""

    feedback: str = parameter(
        "budgeted",
        "-",
        "printed: whatever it costs; budgeted: what the ledger can pay; integral: likewise, "
        "towards the integral of the waves",
        choices=POSITION_FEEDBACKS,
        read_only=True,
    )
    gain: float = parameter(0.0, "sqrt(W)/m", "K_p (0: off)", low=0.0)
