# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What is done about the energy of late decoding, by name, one file each (App. C section 5)."""

from collections.abc import Callable, Mapping

from pmwvc_core.params import ServerParams
from pmwvc_core.server.compensations.corrected import Corrected
from pmwvc_core.server.compensations.interface import Compensation, Untreated
from pmwvc_core.server.compensations.ledger import JointLedger
from pmwvc_core.server.compensations.printed import Printed

__all__ = ["COMPENSATIONS", "Compensation", "Corrected", "JointLedger", "Printed", "Untreated"]

COMPENSATIONS: Mapping[str, Callable[[ServerParams, int], Compensation]] = {
    "none": lambda params, users: Untreated(),
    "printed": lambda params, users: Printed(users, period=params.period_s),
    "corrected": lambda params, users: Corrected(period=params.period_s),
    "ledger": lambda params, users: JointLedger(
        period=params.period_s,
        allowance_w=params.allowance_w,
        allowance_j=params.allowance_j,
        cap_j=params.tank_cap_j,
    ),
}
