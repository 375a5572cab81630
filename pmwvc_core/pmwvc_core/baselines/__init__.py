# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Other controllers to compare with, built from the blocks of ``server``."""

from pmwvc_core.baselines.direct import DirectMaster, DirectServer
from pmwvc_core.baselines.pspm import PspmMaster, PspmServer
from pmwvc_core.baselines.tdpa import TdpaMaster, TdpaServer
from pmwvc_core.baselines.virtual_coupling import VirtualCouplingMaster, VirtualCouplingServer

__all__ = [
    "DirectMaster",
    "DirectServer",
    "PspmMaster",
    "PspmServer",
    "TdpaMaster",
    "TdpaServer",
    "VirtualCouplingMaster",
    "VirtualCouplingServer",
]
