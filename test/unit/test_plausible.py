# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Of a device's samples only what can be is believed: metres, and velocities of the positions."""

import math

import numpy as np
import pytest
from support.loop_rig import TICK_NS

from pmwvc_core.errors import DeviceError
from pmwvc_core.frame import DeviceSample
from pmwvc_master.devices import DeviceInfo
from pmwvc_master.devices.plausible import Plausible, Slope


class Moved:
    """A handle on a sine of 3 cm at 1 Hz, along several axes; its velocities are ``factor`` times
    the true ones, its positions in ``unit``.
    """

    def __init__(self, *, factor=1.0, unit=1.0, step=0.0, dof=1, amplitude=0.03, late=0.0):
        self.info = DeviceInfo("moved", dof, workspace_m=0.1)
        self.factor, self.unit, self.step, self.dof = factor, unit, step, dof
        self.amplitude, self.late, self.closed = amplitude, late, 0

    def open(self): ...
    def write(self, f_m): ...
    def couple(self): ...
    def stop(self): ...

    def close(self):
        self.closed += 1

    def read(self, due_ns):
        t, w = due_ns * 1e-9, 2 * math.pi
        x = self.amplitude * math.cos(w * t) * self.unit
        xd = -self.amplitude * w * math.sin(w * (t - self.late)) * self.unit * self.factor
        if self.step:
            x = round(x / self.step) * self.step
        if self.dof > 1:
            x, xd = x * np.ones(self.dof), xd * np.ones(self.dof)
        return DeviceSample(x=x, xd=xd)


def played(device, seconds=3.0):
    """Return the samples of a device behind the check, what was told, and after which time."""
    told = []
    made = Plausible(device, told.append)
    found = []
    for tick in range(round(seconds * 1000)):
        sample = made.read(tick * TICK_NS)
        found.append((sample.x, sample.xd, sample.valid))
    return found, told


@pytest.mark.parametrize(
    "right", [{}, {"dof": 3}, {"step": 6e-5}, {"factor": 1.8}, {"factor": 0.6}, {"late": 0.02}]
)
def test_velocities_of_the_motion_are_believed(right):
    """Also behind counts of 60 um, and 20 ms late."""
    found, told = played(Moved(**right))
    assert not told
    w, factor = 2 * math.pi, right.get("factor", 1.0)
    t = 2.5 - right.get("late", 0.0)
    expected = -0.03 * w * math.sin(w * t) * factor
    np.testing.assert_allclose(found[2500][1], expected, atol=1e-12)


@pytest.mark.parametrize("factor", [1000.0, 2.2, 2.0, 0.5, 0.4, 0.0, -1.0])
@pytest.mark.parametrize("dof", [1, 3])
def test_velocities_that_are_off_by_two_are_told_within_a_second_and_replaced(factor, dof):
    found, told = played(Moved(factor=factor, dof=dof))
    (text,) = told
    assert text.startswith(f"moved: velocities are {factor:.3g} times") or factor == 0.0
    true = [-0.03 * 2 * math.pi * math.sin(2 * math.pi * k * 1e-3) for k in range(3000)]
    seen = np.array([np.max(np.atleast_1d(xd)) for _, xd, _ in found])
    replaced = np.abs(seen - true) < 0.005
    assert replaced[1100:].all() and not replaced[200:300].any()


def test_a_handle_at_rest_tells_nothing_of_velocities():
    assert played(Moved(factor=1000.0, amplitude=1e-5))[1] == []


def test_a_gap_and_a_time_that_goes_back_are_no_motion():
    """The handle jumps by 10 cm in gaps of 30 ms, ten times a second."""
    slope, now_ns, x, found = Slope(), 0, 0.0, []
    for tick in range(3000):
        gap = tick % 70 == 0
        now_ns, x = now_ns + (30 if gap else 1) * TICK_NS, x + (0.1 if gap else 1e-4)
        found.append(slope.add(now_ns, x, 0.15))
    ratios = [each for each in found if each is not None]
    assert len(ratios) == 4 and ratios == pytest.approx([1.5] * 4)
    assert slope.add(0, 0.0, 0.15) is None


@pytest.mark.parametrize("dof", [1, 3])
def test_millimetres_are_refused_when_opened(dof):
    device = Moved(unit=1000.0, dof=dof)
    with pytest.raises(DeviceError, match=r"moved: position .* at most 0\.3 m can"):
        Plausible(device, print).open()
    assert device.closed == 1
    Plausible(Moved(dof=dof), print).open()


def test_a_position_that_gets_too_far_later_is_no_sample_and_told_once():
    device = Moved(amplitude=0.5)
    found, told = played(device)
    (text,) = told
    assert text.endswith("are these mm?")
    for (x, _, valid), tick in zip(found, range(3000), strict=True):
        assert valid == (abs(0.5 * math.cos(2 * math.pi * tick * 1e-3)) <= 0.3 + 1e-12), x


class Own:
    """A device that keeps its state in its sample, as that of the documentation."""

    info = DeviceInfo("own", 1, workspace_m=0.1)
    sample = DeviceSample(x=0.0, xd=3.0)

    def read(self, due_ns):
        self.sample.x = 0.5 if due_ns == TICK_NS else 1e-3 * (due_ns / TICK_NS % 50)
        return self.sample

    open = write = couple = stop = close = None


def test_what_is_the_devices_own_is_not_changed():
    device, told = Own(), []
    made = Plausible(device, told.append)
    assert made.read(0).valid and not made.read(TICK_NS).valid and made.read(2 * TICK_NS).valid
    for tick in range(3, 1500):
        sample = made.read(tick * TICK_NS)
    assert len(told) == 2 and sample.xd == pytest.approx(1.0)
    assert (device.sample.valid, device.sample.xd) == (True, 3.0)


@pytest.mark.parametrize(
    ("x", "workspace_m", "limit"),
    [
        ([0.29, -0.3, 0.0], 0.1, ""),
        ([0.0, 0.31, 0.0], 0.1, "position (0, 0.31, 0) m from the middle, at most 0.3 m can be"),
        ([0.99, 0.0, 0.0], None, ""),
        ([0.0, 0.0, -1.1], None, "at most 1 m can be: are these mm?"),
        ([math.nan, 0.0, 0.0], 0.1, ""),
        ([math.inf, 0.0, 0.0], 0.1, "at most 0.3 m"),
    ],
)
def test_beyond_three_workspaces_or_a_metre_no_hand_can_be(x, workspace_m, limit):
    device, told = Moved(dof=3), []
    device.info = DeviceInfo("moved", 3, workspace_m=workspace_m)
    device.read = lambda _: DeviceSample(x=np.array(x), xd=np.zeros(3))
    sample = Plausible(device, told.append).read(0)
    assert (sample.valid, len(told)) == ((False, 1) if limit else (True, 0))
    assert all(limit in text for text in told)


@pytest.mark.parametrize("dof", [1, 3, 6])
def test_a_sample_beyond_the_workspace_and_one_percent_says_so(dof):
    """Along the first three axes: a turn knows no workspace."""
    device = Moved(dof=dof)
    for x, outside in ((0.1009, False), (0.1011, True), (-0.1011, True)):
        device.read = lambda _, x=x: DeviceSample(x=x * np.eye(dof)[0] if dof > 1 else x)
        assert Plausible(device, print).read(0).outside is outside
    if dof == 6:
        device.read = lambda _: DeviceSample(x=0.5 * np.eye(6)[4])
        sample = Plausible(device, print).read(0)
        assert (sample.outside, sample.valid) == (False, True)
