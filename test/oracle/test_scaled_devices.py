# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A scaled device in virtual time against another route: device and hand as they are, with a
transformer made by hand between them and the port.
"""

from dataclasses import replace

import numpy as np
import pytest

from pmwvc_bringup import scenarios as files
from pmwvc_core.ends.user_end import DevicePlant
from pmwvc_core.frame import DeviceSample
from pmwvc_core.params import OperatorParams
from pmwvc_core.params.user import RemoteHandParams
from pmwvc_core.plant.hands import make_hand
from pmwvc_core.simulation.conditions import place_of
from pmwvc_core.simulation.session import SteppedSession, simulate

SIGNALS = ("x_m", "xd_m", "f_h", "f_applied")


class Behind:
    """What the port sees of a plant through a lever of ratio s."""

    def __init__(self, plant, scale):
        self.plant, self.scale, self.sample = plant, scale, DeviceSample(work=(0.0, 0.0))
        self._show(plant.sample)

    @property
    def s(self):
        return self.plant.s

    def _show(self, there):
        own, s = self.sample, self.scale
        own.x, own.xd, own.f_h, own.work = there.x * s, there.xd * s, there.f_h / s, there.work

    def sense(self, acts):
        self._show(self.plant.sense(acts))
        return self.sample

    def step(self, f_m):
        self._show(self.plant.step(f_m * self.scale))


def by_hand(scenario, scale):
    """Run a scenario of scale 1 whose first user sits behind a lever; limits are those before
    it.
    """
    (user, *others), task = scenario.users, scenario.task
    safety = user.safety
    limits = {
        "max_force": safety.max_force / scale, "max_slew": safety.max_slew / scale,
        "damper_velocity": safety.damper_velocity * scale,
        "fault_velocity": safety.fault_velocity * scale,
    }  # fmt: skip
    user = replace(user, given_safety=replace(safety, **limits))
    batch = SteppedSession(replace(scenario, users=(user, *others)))
    at = place_of(user, scenario)
    seen = at._replace(half_width_m=at.half_width_m / scale, start_m=at.start_m / scale)
    ways = {n: getattr(task, n) / scale for n in ("distance_m", "sideways_m", "upwards_m")}
    hand = make_hand(user.operator, replace(task, **ways), seen)
    plant = DevicePlant(user.device, hand, seen.start, tick_s=at.tick_s)
    batch.users[0].device = Behind(plant, scale)
    batch.run(lambda _: None)
    return batch.traces()


@pytest.mark.parametrize(
    ("settings", "scale"),
    [
        ((), 2.0),
        (("dof=3", "task.upwards_m=0.02", "device.friction=0.2", "device.damping=1.5"), 0.7),
        (("operator.kind=sinusoid", "operator.force=2", "device.encoder_step_m=1e-5",
          "device.velocity=euler", "device.workspace_m=0.06"), 2.0),
    ],
)  # fmt: skip
def test_a_scaled_device_moves_as_one_behind_a_lever(settings, scale):
    scenario = files.load("carry_16ms", settings_texts=list(settings), duration_s=3.0)
    user, *others = scenario.users
    scaled = replace(user, given_device=replace(user.given_device, scale=scale))
    [traces] = simulate([replace(scenario, users=(scaled, *others))])
    expected = by_hand(scenario, scale).users[0]
    for name in SIGNALS:
        largest = np.abs(getattr(expected, name)).max()
        found = getattr(traces.users[0], name)
        np.testing.assert_allclose(found, getattr(expected, name), atol=1e-6 * largest, rtol=0)
        assert largest > 0.0
    if not settings:  # the control
        [plain] = simulate([scenario])
        assert np.abs(plain.users[0].x_m - expected.x_m).max() > 1e-3


def test_limits_are_those_of_the_devices_own_force():
    settings = ["device.scale=2", "safety.max_force=1", "safety.max_slew=20"]
    scenario = files.load("carry_16ms", settings_texts=settings, duration_s=3.0)
    [traces] = simulate([scenario])
    for user in traces.users:
        own_n = 2.0 * user.f_applied[:, 0]
        assert np.abs(own_n).max() == pytest.approx(1.0)
        assert np.abs(np.diff(own_n)).max() <= 20.0 * 0.001 * (1.0 + 1e-9)


def test_a_hand_behind_a_scale_has_all_its_parameters_by_their_units():
    """Each by the transformer itself: impedances by 1/s^2, forces by 1/s, ways by s."""
    [user, _] = files.load("carry_16ms", settings_texts=["device.scale=2"], duration_s=1.0).users
    given, seen = user.given_operator, user.operator
    quarter = {"mass", "damping", "stiffness", "grip_stiffness", "grip_damping"}
    for name in set(OperatorParams.__dataclass_fields__) - {"remote", "scale"}:
        factor = 0.25 if name in quarter else 0.5 if name in ("force", "squeeze") else 1
        assert getattr(seen, name) == getattr(given, name) * factor, name
    factors = {"speed_m_s": 2.0, "reach_n": 0.5}
    for name in RemoteHandParams.__dataclass_fields__:
        factor = factors.get(name, 0.25)
        assert getattr(seen.remote, name) == getattr(given.remote, name) * factor, name
    of_file = {"playback_force": 0.5, "playback_motion": 2.0}
    for kind, factor in of_file.items():
        played = replace(user, given_operator=replace(given, kind=kind, scale=3.0, offset=1.0))
        assert (played.operator.scale, played.operator.offset) == (3.0 * factor, factor)
