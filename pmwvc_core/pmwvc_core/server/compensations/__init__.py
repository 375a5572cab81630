# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Compensations of the energy of late decoding by name (App. C section 5): the
library, and entry points of the group ``pmwvc.compensations``.
"""

from pmwvc_core.plugins import Records
from pmwvc_core.server.compensations import corrected, ledger, printed
from pmwvc_core.server.compensations.record import UNTREATED, Compensation, Treatment, Wave

__all__ = ["COMPENSATIONS", "Compensation", "Treatment", "Wave"]

COMPENSATIONS: Records[Compensation] = Records(
    Compensation,
    (UNTREATED, printed.RECORD, corrected.RECORD, ledger.RECORD),
    group="pmwvc.compensations",
    parameter="server.compensation",
    what="a compensation",
)
