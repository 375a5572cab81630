# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The setup of a vendor's device, and the device as a master has it."""

from pmwvc_core.params import DeviceParams, OperatorParams, TaskParams
from pmwvc_master.devices import DeviceSetup
from pmwvc_master.devices.mapped import Mapped
from pmwvc_master.devices.plausible import Plausible


def vendor_setup(plugin, dof=1, *, node=None, **device):
    return DeviceSetup(
        dof=dof,
        tick_s=0.001,
        side=-1,
        half_width_m=0.03,
        start_m=-0.03,
        lever_m=0.05,
        device=DeviceParams(plugin=plugin, **device),
        operator=OperatorParams(),
        task=TaskParams(),
        node=node,
    )


class Whole(Mapped):
    """What ``make_device`` makes of a driver; what it has not is the driver's."""

    def __init__(self, driver, setup):
        super().__init__(Plausible(driver, print), setup)
        self.driver = driver

    def __getattr__(self, name):
        return getattr(self.driver, name)


def whole(kind, params, name, dof=1, **device):
    setup = vendor_setup(name, dof, **device)
    return Whole(kind(setup, params), setup)
