# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A Haply device at a fake Inverse Service: opened, and asked tick by tick."""

import contextlib

from pmwvc_master.devices import haply
from pmwvc_master.devices.haply import HaplyDevice, HaplyParams
from support.loop_rig import TICK_NS
from support.vendor_setup import whole

FOREVER_NS = -60 * 10**9  # a clock that is never due: reads wait until an answer has come


def let_wait(monkeypatch):
    """Have reads wait for an answer."""
    monkeypatch.setattr(haply, "monotonic_ns", lambda: FOREVER_NS)


@contextlib.contextmanager
def opened(service, *, dof=1, axes="", clutch=0, **params):
    params = HaplyParams(service=service.url, **params)
    device = whole(HaplyDevice, params, "haply", dof, axes=axes, clutch=clutch)
    try:
        device.open()
        assert service.force()[1] == {"x": 0.0, "y": 0.0, "z": 0.0}
        yield device
        device.stop()
    finally:
        if service.held is not None:
            service.release()
        device.close()


def exchanged(service, device, f_m, tick=1):
    """Return the force that came for a tick's, then the sample of the next tick."""
    device.read(tick * TICK_NS)
    device.write(f_m)
    force = service.force()[1]
    return force, device.read((tick + 1) * TICK_NS)
