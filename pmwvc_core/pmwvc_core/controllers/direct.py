# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of ``direct``: velocity up, force down."""

from dataclasses import replace

from pmwvc_core.baselines.direct import DirectMaster, DirectServer
from pmwvc_core.controllers.record import HELD, Controller

RECORD = Controller(
    name="direct",
    words="Direct coupling: nothing keeps it passive as delay or stiffness grows.",
    waves=False,
    make_master=lambda params, _: DirectMaster(tick_s=params.tick_s),
    make_server=DirectServer,
    linear="direct",
    drifts=True,
    coupling=replace(HELD, moves=None),
)
