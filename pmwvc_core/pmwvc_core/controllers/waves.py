# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The record of ``pmwvc``: wave variables both ways."""

from pmwvc_core.controllers.record import Controller
from pmwvc_core.master import strict_accounts
from pmwvc_core.master.port import WaveMaster
from pmwvc_core.master.port_filters import filter_bank, local_model, velocity_filter
from pmwvc_core.master.position import feedback as position
from pmwvc_core.master.strict_port import StrictMaster
from pmwvc_core.params import BaselineParams, MasterParams
from pmwvc_core.server import avatar_brake
from pmwvc_core.server.black_box import accounts as black_box
from pmwvc_core.server.black_box.port import BlackBoxServer
from pmwvc_core.server.port import WaveServer


def storage_j(master: MasterParams, baseline: BaselineParams) -> float:
    """Return what position feedback may spend before it is paid [J]; none as published."""
    position = master.position
    return float(position.storage_j) if position.is_paid else 0.0


RECORD = Controller(
    name="pmwvc",
    words="Wave variables: stable at any constant delay where the gains of both ends prove it.",
    waves=True,
    make_master=lambda params, _: WaveMaster(params),
    make_strict=StrictMaster,
    make_server=WaveServer,
    make_black_box=lambda params, ports, environment, call: BlackBoxServer(
        params, ports, environment, call=call
    ),
    linear="pmwvc",
    drifts=True,
    storage_j=storage_j,
    accounts=(
        *velocity_filter.ENTRIES,
        *filter_bank.ENTRIES,
        *local_model.ENTRIES,
        *position.ENTRIES,
        *strict_accounts.ENTRIES,
        *avatar_brake.ENTRIES,
        *black_box.ENTRIES,
    ),
)
