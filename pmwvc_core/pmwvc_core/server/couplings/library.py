# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Couplings by name: the library, and entry points of the group ``pmwvc.couplings``."""

from pmwvc_core.plugins import Records
from pmwvc_core.server.couplings import (
    black_box,
    implicit,
    one_frame_late,
    one_step_delay,
    unwrapped,
)
from pmwvc_core.server.couplings.record import Coupling

COUPLINGS: Records[Coupling] = Records(
    Coupling,
    (one.RECORD for one in (implicit, one_step_delay, one_frame_late, unwrapped, black_box)),
    group="pmwvc.couplings",
    parameter="server.coupling",
    what="a coupling",
)
