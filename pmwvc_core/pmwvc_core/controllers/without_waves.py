# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The records of the controllers without waves."""

from dataclasses import replace

from pmwvc_core.baselines import tuning
from pmwvc_core.controllers.accounts import OF_PSPM, OF_TDPA
from pmwvc_core.controllers.record import HELD, Controller, Rule
from pmwvc_core.server.couplings.record import forward

DIRECT = Controller(
    name="direct",
    words="Direct coupling: nothing keeps it passive as delay or stiffness grows.",
    waves=False,
    linear="direct",
    drifts=True,
    coupling=replace(HELD, moves=None),
)
VIRTUAL_COUPLING = Controller(
    name="virtual_coupling",
    words="Virtual coupling: stable where its rules are met; energy is not monitored.",
    waves=False,
    linear="virtual_coupling",
    coupling=HELD,
    rule=Rule(
        "virtual_coupling",
        tuning.check_virtual_coupling,
        {"stiffness": (30.0, 2000.0), "damping": (0.3, 15.0)},
    ),
)
TDPA = Controller(
    name="tdpa",
    words="Time-domain passivity control: energy that the link generated is dissipated "
    "later; a device at rest dissipates none.",
    waves=False,
    linear=None,  # without its dissipation nothing of it is left
    rule=Rule(
        "tdpa",
        tuning.check_tdpa,
        {
            "damping": (0.3, 20.0),
            "damping_max": (5.0, 100.0),
            "fade_s": (1e-3, 0.05),
            "drift_share": (0.01, 0.5),
        },
    ),
    coupling=replace(HELD, moves=forward),
    accounts=OF_TDPA,
)
PSPM = Controller(
    name="pspm",
    words="Set-position modulation: neither end releases more energy than its tank holds.",
    waves=False,
    linear="virtual_coupling",  # with tanks that are never empty
    coupling=HELD,
    rule=Rule(
        "pspm",
        tuning.check_pspm,
        {
            "stiffness": (50.0, 3000.0),
            "damping": (0.3, 10.0),
            "initial_j": (2e-3, 0.2),
            "cap_j": (2e-3, 0.2),
        },
    ),
    storage_j=lambda _, baseline: 2.0 * float(baseline.pspm.initial_j),  # [J] of both tanks
    accounts=OF_PSPM,
)
RECORDS = (DIRECT, VIRTUAL_COUPLING, TDPA, PSPM)
