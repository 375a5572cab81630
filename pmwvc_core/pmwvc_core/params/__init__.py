# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters as frozen dataclasses: one source for defaults, units, ranges and descriptions."""

from pmwvc_core.params.fields import Spec as Spec
from pmwvc_core.params.fields import Validated as Validated
from pmwvc_core.params.fields import specs as specs
from pmwvc_core.params.network import LinkParams as LinkParams
from pmwvc_core.params.port_filters import BankParams as BankParams
from pmwvc_core.params.port_filters import LocalModelParams as LocalModelParams
from pmwvc_core.params.port_filters import PositionParams as PositionParams
from pmwvc_core.params.port_filters import VelocityFilterParams as VelocityFilterParams
from pmwvc_core.params.ports import DeadbandParams as DeadbandParams
from pmwvc_core.params.ports import FilterParams as FilterParams
from pmwvc_core.params.ports import MasterParams as MasterParams
from pmwvc_core.params.server import BaselineParams as BaselineParams
from pmwvc_core.params.server import ContactParams as ContactParams
from pmwvc_core.params.server import ServerParams as ServerParams
from pmwvc_core.params.user import DeviceParams as DeviceParams
from pmwvc_core.params.user import OperatorParams as OperatorParams
from pmwvc_core.params.user import SafetyParams as SafetyParams
from pmwvc_core.params.user import TaskParams as TaskParams
