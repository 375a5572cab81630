# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters as frozen dataclasses: one source for defaults, units, ranges and descriptions."""

from pmwvc_core.params.baselines import BaselineParams
from pmwvc_core.params.fields import Spec, Validated, groups, specs
from pmwvc_core.params.master import FilterParams, MasterParams
from pmwvc_core.params.network import LinkParams
from pmwvc_core.params.port_filters import (
    BankParams,
    LocalModelParams,
    PositionParams,
    VelocityFilterParams,
)
from pmwvc_core.params.ports import DeadbandParams
from pmwvc_core.params.server import (
    ActiveWallParams,
    ContactParams,
    HuntCrossleyParams,
    ServerParams,
)
from pmwvc_core.params.user import (
    DeviceParams,
    OperatorParams,
    RemoteHandParams,
    SafetyParams,
    TaskParams,
)

__all__ = [
    "ActiveWallParams",
    "BankParams",
    "BaselineParams",
    "ContactParams",
    "DeadbandParams",
    "DeviceParams",
    "FilterParams",
    "HuntCrossleyParams",
    "LinkParams",
    "LocalModelParams",
    "MasterParams",
    "OperatorParams",
    "PositionParams",
    "RemoteHandParams",
    "SafetyParams",
    "ServerParams",
    "Spec",
    "TaskParams",
    "Validated",
    "VelocityFilterParams",
    "groups",
    "specs",
]
