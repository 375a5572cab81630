# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of ``virtual_coupling``: a spring and a damper between device and avatar."""

from pmwvc_core.baselines import tuning
from pmwvc_core.baselines.virtual_coupling import VirtualCouplingMaster, VirtualCouplingServer
from pmwvc_core.controllers.record import HELD, Controller, Rule

RECORD = Controller(
    name="virtual_coupling",
    words="Virtual coupling: stable where its rules are met; energy is not watched.",
    waves=False,
    make_master=lambda params, baseline: VirtualCouplingMaster(
        baseline.virtual_coupling, tick_s=params.tick_s
    ),
    make_server=VirtualCouplingServer,
    linear="virtual_coupling",
    coupling=HELD,
    rule=Rule("virtual_coupling", tuning.virtual_coupling, tuning.check_virtual_coupling),
)
