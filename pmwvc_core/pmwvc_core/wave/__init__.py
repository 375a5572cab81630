# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The wave channel: encode, filter and rate drop, packet, receiver, hold, decode."""

from pmwvc_core.wave.aliasing import delay_of, warnings_of, worst_case_gain
from pmwvc_core.wave.filter_design import design, half_power_hz, pole_of
from pmwvc_core.wave.filters import AntiAliasing
from pmwvc_core.wave.impedance import Impedance, MatrixImpedance, impedance_of
from pmwvc_core.wave.ledger import EnergyLedger, PortLedger
from pmwvc_core.wave.packet import (
    FLAG_DIRECT,
    FLAG_LEAVING,
    FLAG_LIMITED,
    Packer,
    WavePacket,
    size_bytes,
)
from pmwvc_core.wave.rates import Hold
from pmwvc_core.wave.receiver import Receiver, Verdict
from pmwvc_core.wave.transform import (
    decode_master,
    decode_server,
    encode_master,
    encode_server,
    power,
)

__all__ = [
    "FLAG_DIRECT",
    "FLAG_LEAVING",
    "FLAG_LIMITED",
    "AntiAliasing",
    "EnergyLedger",
    "Hold",
    "Impedance",
    "MatrixImpedance",
    "Packer",
    "PortLedger",
    "Receiver",
    "Verdict",
    "WavePacket",
    "decode_master",
    "decode_server",
    "delay_of",
    "design",
    "encode_master",
    "encode_server",
    "half_power_hz",
    "impedance_of",
    "pole_of",
    "power",
    "size_bytes",
    "warnings_of",
    "worst_case_gain",
]
