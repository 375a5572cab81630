# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Compensations of the energy of late decoding by name, one file each (App. C section 5): the
library, and entry points of the group ``pmwvc.compensations``.
"""

from pmwvc_core.plugins import Records
from pmwvc_core.server.compensations import corrected, ledger, printed, untreated
from pmwvc_core.server.compensations.record import Compensation, Treatment, Wave

__all__ = ["COMPENSATIONS", "Compensation", "Treatment", "Wave"]

COMPENSATIONS: Records[Compensation] = Records(
    Compensation,
    (one.RECORD for one in (untreated, printed, corrected, ledger)),
    group="pmwvc.compensations",
    parameter="server.compensation",
    what="a compensation",
)
