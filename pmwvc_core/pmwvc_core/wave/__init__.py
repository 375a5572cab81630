# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Wave variables at run time: transformation, filter and rate drop, hold, impedance, ledgers."""

from pmwvc_core.wave.impedance import Impedance, MatrixImpedance, impedance_of
from pmwvc_core.wave.ledger import EnergyLedger, PortLedger
from pmwvc_core.wave.rates import AntiAliasing, Hold
from pmwvc_core.wave.transform import WavePort

__all__ = [
    "AntiAliasing",
    "EnergyLedger",
    "Hold",
    "Impedance",
    "MatrixImpedance",
    "PortLedger",
    "WavePort",
    "impedance_of",
]
