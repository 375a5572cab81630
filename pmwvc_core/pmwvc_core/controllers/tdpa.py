# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of ``tdpa``: time-domain passivity control."""

from dataclasses import replace

from pmwvc_core.baselines import tuning
from pmwvc_core.baselines.tdpa import ENTRIES, TdpaMaster, TdpaServer
from pmwvc_core.controllers.record import HELD, Controller, Rule
from pmwvc_core.server.couplings.record import forward

RECORD = Controller(
    name="tdpa",
    words="Time-domain passivity control: energy that the link generated is dissipated "
    "later; a device at rest dissipates none.",
    waves=False,
    make_master=lambda params, baseline: TdpaMaster(baseline.tdpa, tick_s=params.tick_s),
    make_server=TdpaServer,
    linear="direct",  # without dissipation
    rule=Rule("tdpa", tuning.tdpa, tuning.check_tdpa),
    coupling=replace(HELD, moves=forward),
    accounts=ENTRIES,
)
