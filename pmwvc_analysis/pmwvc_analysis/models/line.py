# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user's end in the exact model: force loop, device and the links both ways."""

import dataclasses
from typing import Any

import numpy as np

from pmwvc_analysis.models.links import Link, Times, delay_ticks, hyperperiod_ticks, serve_phase
from pmwvc_analysis.models.variation import lengths
from pmwvc_core.controllers.library import has_waves
from pmwvc_core.frame.assembly import force_loop_of
from pmwvc_core.frame.device_sample import DeviceSample
from pmwvc_core.frame.schedule import AT_ONCE, LIVE
from pmwvc_core.master.safety.limiter import SafetyLimiter
from pmwvc_core.master.strict_port import StrictMaster
from pmwvc_core.numeric import Value
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.scenario.scenario import Scenario, User


class Unlimited(SafetyLimiter):
    """Limits that are far away."""

    inactive = True

    def step(self, f_asked: Value, *motion: Any) -> Value:
        """Return the force asked for [N]."""
        self.inactive = True
        return f_asked


class Line:
    """One user's end with its device and the links both ways.

    Parameters
    ----------
    index, dof
        Number of the user, from 0; axes of the model.
    ports
        Numbers of its ports at the server: several where it stands for equal users.
    live
        Whether the phases are those of a live session.

    Attributes
    ----------
    frame, answer, serve
        When it sends, takes an answer, and when the server steps.
    delay_down, delay
        From the server, and both ways together [ticks].
    """

    def __init__(
        self, scenario: Scenario, index: int, *, ports: list[int], dof: int, live: bool
    ) -> None:
        self.user, self.ports, tick_s = scenario.users[index], ports, scenario.tick_s
        user, period_s, schedule = self.user, scenario.server.period_s, LIVE if live else AT_ONCE
        self.name, self.waves = user.name, has_waves(scenario.controller)
        self.loop = force_loop_of(scenario, index, schedule=schedule, dof=dof)
        self.loop.safety = Unlimited(user.safety, tick_s=tick_s, packet_s=period_s)
        if isinstance(self.loop.controller, StrictMaster):  # a device with counts is not linear
            self.loop.controller.tracker.take_as_exact()
        self.device = SimulatedDevice(user.device, tick_s=tick_s, dof=dof)
        runs = max(lengths(scenario), default=1)
        if runs > 1:  # signals have the shape of a batch from the first packet on
            self.device.place(np.zeros((1, runs, dof)))
        self.frame = Times(user.master.rate_drop, 0)
        self.answer = Times(user.master.rate_drop, self.loop.frames.answer_tick)
        self.serve = Times(scenario.period_ticks, serve_phase(scenario, live=live))
        up = delay_ticks(user.link_up, tick_s=tick_s, live=live)
        self.delay_down = delay_ticks(user.link_down, tick_s=tick_s, live=live)
        self.delay = up + self.delay_down
        every = Times(1, 0)  # a playout takes packets when they arrive
        read = (every, every) if scenario.strict else (self.serve, self.answer)
        ticks = hyperperiod_ticks(scenario)
        self.up = Link(self.frame, read[0], delay=up, ticks=ticks)
        self.down = Link(self.serve, read[1], delay=self.delay_down, ticks=ticks)

    def send(self, tick: int, number: int, now_ns: int) -> None:
        """Send the packet of a frame that starts."""
        sample = DeviceSample(*self.device.read())
        self.up.send(tick, self.loop.start_frame(number, now_ns, sample))

    def step(self, tick: int, number: int, now_ns: int, f_h: Value) -> tuple[Value, Value, Value]:
        """Go one tick on; return x, xd and the controller's force at its start."""
        sample = DeviceSample(*self.device.read(), f_h)
        force, _, _ = self.loop.tick(number, now_ns, sample, self.down.collect(tick))
        self.device.step(f_h, force)
        return sample.x, sample.xd, force


def two_sided(user: User) -> User:
    """Return a user who is in contact, and whose local model is there, all the time."""
    local = dataclasses.replace(user.master.local_model, acts="everywhere")
    master = dataclasses.replace(user.master, local_model=local)
    contact = dataclasses.replace(user.contact, contact="bilateral")
    return dataclasses.replace(user, master=master, contact=contact)
