# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The check of a device before a hand is on it finds each thing that is wrong, and that only."""

import numpy as np
import pytest

from pmwvc_core.errors import DeviceError
from pmwvc_core.frame import DeviceSample
from pmwvc_core.runtime.pacing import Pacer
from pmwvc_master.devices import DeviceInfo
from pmwvc_master.devices.check import FAST_M_S, SLEW_N_S, DeviceCheck
from pmwvc_master.devices.plausible import Slope

TICK_S = 0.001
TEXTS = ("Keep the handle still", "Move the handle along")


class Desk:
    """A handle of 0.2 kg with some friction, which a person moves by 6 cm where it is asked for;
    time passes by ticks. What is wrong with it is said by name.
    """

    def __init__(self, dof=3, *, axes=(0, 1, 2), sign=1.0, unit=1.0, factor=1.0, every=1,
                 noise_m=2e-6, push=1.0, held=False, watchdog_s=0.02, valid=True):  # fmt: skip
        self.info = DeviceInfo("desk", dof)
        self.axes, self.sign, self.unit, self.factor = axes, sign, unit, factor
        self.every, self.noise_m, self.push, self.held = every, noise_m, push, held
        self.watchdog_s, self.valid = watchdog_s, valid
        self.rng = np.random.default_rng(1)
        self.x, self.xd = np.zeros(dof), np.zeros(dof)
        self.force, self.called, self.now, self.moves = np.zeros(dof), 0.0, 0.0, None
        self.asked, self.written, self.stopped = [], [], 0

    def ask(self, text):
        self.asked.append(text)
        count = len(self.asked) - 2
        self.moves = (self.axes[count], self.now) if text.startswith("Move") else None
        self.xd = 0.0 * self.xd

    def clock(self):
        return round(self.now * 1e9)

    def sleep(self, until_ns):
        """Let a tick pass; it begins 50 us late."""
        self.now = until_ns * 1e-9 + 50e-6
        force = self.force if self.now - self.called <= self.watchdog_s else 0.0 * self.force
        if self.moves is not None:
            axis, since = self.moves
            self.xd = 0.0 * self.xd
            self.xd[axis] = self.sign * 0.03 * max(0.0, min(1.0, 2.0 - (self.now - since)))
        elif not self.held:
            self.xd = self.xd + self.push * force / 0.2 * TICK_S
        self.x = self.x + self.xd * TICK_S

    def read(self, due_ns):
        fresh = int(self.now / TICK_S) % self.every == 0
        noise_m = self.noise_m if self.moves is None else 0.0
        noise = noise_m * self.rng.uniform(-0.5, 0.5, len(self.x))
        x, xd = (self.x + noise) * self.unit, self.xd * self.unit * self.factor
        x, xd = (x, xd) if len(x) > 1 else (float(x[0]), float(xd[0]))
        return DeviceSample(
            x=x, xd=xd, fresh=fresh, valid=self.valid, measured_ns=due_ns - 300_000
        )

    def write(self, f_m):
        self.called, self.force = self.now, -np.atleast_1d(f_m)
        self.written.append(self.force)

    def stop(self):
        self.stopped += 1
        self.force = 0.0 * self.force


class Given:
    """A desk as a master has it, without axes and scale; what is wrong is not corrected."""

    def __init__(self, desk):
        self._desk, self._slope, self.ratio, self.device = desk, Slope(), 0.0, self
        self.write, self.stop, self.info = desk.write, desk.stop, desk.info

    def read(self, due_ns):
        sample = self._desk.read(due_ns)
        if sample.fresh and (ratio := self._slope.add(due_ns, sample.x, sample.xd)):
            self.ratio = ratio
        return sample


def pacer(desk):
    return Pacer(round(TICK_S * 1e9), clock=desk.clock, sleep=desk.sleep)


def lines(push_n=0.0, **wrong):
    desk = Desk(**wrong)
    return list(DeviceCheck(Given(desk), pacer(desk), desk.ask).lines(push_n)), desk


def test_a_device_as_it_should_be_is_told_so_and_not_pushed():
    found, desk = lines()
    assert [line.text for line in found if not line.right] == []
    texts = [line.text for line in found]
    assert texts[0].startswith("1000 new samples a second, 0.35 ms old (99 %: 0.35 ms)")
    assert texts[1].startswith("noise: 2.0 um peak to peak, velocity 0.00 mm/s rms")
    assert texts[2].startswith("motion along axis 0: +45 mm along axis 0")
    assert texts[-1].startswith("velocity: 1 times")
    assert not np.any(desk.written)
    assert [text.startswith(TEXTS[min(k, 1)]) for k, text in enumerate(desk.asked)] == [True] * 4


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"every": 10}, "100 new samples a second, .* too few for stiff contacts"),
        ({"noise_m": 0.0015}, "um peak to peak .*was the handle still"),
        ({"factor": 1000.0}, "velocity: 1e+03 times the positions' slope"),
        ({"factor": 0.3}, "velocity: 0.3 times"),
    ],
)
def test_one_thing_that_is_wrong_is_one_line(wrong, text):
    found, _ = lines(**wrong, dof=1)
    (line,) = [line.text for line in found if not line.right]
    assert all(part in line for part in text.split(" .*"))


@pytest.mark.parametrize(
    ("wrong", "axes", "text"),
    [
        ({"axes": (1, 0, 2)}, (0, 1), ": +45 mm along axis 1: change order or signs"),
        ({"sign": -1.0}, (0, 1, 2), ": -45 mm along axis 0: change order or signs"),
        ({"unit": 1000.0}, (0, 1, 2), ": +4.5e+04 mm along axis 0: was it moved so? If it"),
        ({"unit": 0.001}, (0, 1, 2), ": +0.045 mm along axis 0: was it moved so?"),
    ],
)
def test_axes_that_are_others_turned_or_no_metres_are_named(wrong, axes, text):
    found, _ = lines(**wrong, noise_m=1e-9)
    of_axes = [line for line in found if line.text.startswith("motion")]
    assert tuple(k for k, line in enumerate(of_axes) if not line.right) == axes
    assert of_axes[0].text.startswith(f"motion along axis 0{text}")


@pytest.mark.parametrize("dof", [1, 3])
def test_a_push_rises_at_its_slew_moves_the_handle_forwards_and_ends_when_nobody_calls(dof):
    found, desk = lines(0.2, dof=dof)
    assert [line.text for line in found if not line.right] == []
    pushes = [line.text for line in found if line.text.startswith("push")]
    assert len(pushes) == dof and pushes[0].startswith("push along axis 0: +")
    assert found[-1].text.endswith("the push ended, or the handle was held")
    forces = np.array(desk.written)
    assert forces.max() == pytest.approx(0.2) and forces.min() == 0.0
    assert np.diff(forces, axis=0).max() <= SLEW_N_S * TICK_S + 1e-12
    assert not desk.force.any() and desk.stopped == 1


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"push": -1.0}, "change order or signs of axes or forces"),
        ({"held": True}, "held fast, or no force?"),
        ({"watchdog_s": 9.0}, "the push went on"),
    ],
)
def test_a_push_that_is_wrong_is_named(wrong, text):
    found, _ = lines(0.2, **wrong, dof=1)
    assert any(line.text.endswith(text) for line in found if not line.right)


def test_a_handle_that_gets_fast_is_pushed_no_more():
    light, desk = lines(1.0, push=20.0, dof=1)
    forces = np.array(desk.written)[:, 0]
    assert 0.0 < forces.max() < 1.0 and any(line.text.startswith("push") for line in light)
    assert abs(desk.xd[0]) < 4.0 * FAST_M_S


def test_a_device_without_a_valid_sample_is_refused_and_never_pushed():
    desk = Desk(valid=False)
    with pytest.raises(DeviceError, match="desk: no sample in 2 s; is it on"):
        list(DeviceCheck(desk, pacer(desk), desk.ask).lines(0.2))
    assert not np.any(desk.written)
