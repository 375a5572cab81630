# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The setup of a vendor's device."""

from pmwvc_core.params import DeviceParams, OperatorParams, TaskParams
from pmwvc_master.devices import DeviceSetup


def vendor_setup(plugin, dof=1, *, node=None):
    return DeviceSetup(
        dof=dof,
        tick_s=0.001,
        side=-1,
        half_width_m=0.03,
        start_m=-0.03,
        lever_m=0.05,
        seed=1,
        device=DeviceParams(plugin=plugin),
        operator=OperatorParams(),
        task=TaskParams(),
        node=node,
    )
