# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of ``pspm``: passive set-position modulation."""

from pmwvc_core.baselines import tuning
from pmwvc_core.baselines.pspm import ENTRIES, PspmMaster, PspmServer
from pmwvc_core.controllers.record import HELD, Controller, Rule
from pmwvc_core.params import BaselineParams, MasterParams


def storage_j(master: MasterParams, baseline: BaselineParams) -> float:
    """Return the energy of the tanks at both ends [J]."""
    return 2.0 * float(baseline.pspm.initial_j)


RECORD = Controller(
    name="pspm",
    words="Set-position modulation: neither end releases more energy than its tank holds.",
    waves=False,
    make_master=lambda params, baseline: PspmMaster(baseline.pspm, tick_s=params.tick_s),
    make_server=PspmServer,
    linear="virtual_coupling",  # with tanks that are never empty
    coupling=HELD,
    rule=Rule("pspm", tuning.pspm, tuning.check_pspm),
    storage_j=storage_j,
    accounts=ENTRIES,
)
