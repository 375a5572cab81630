# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user's end in the exact model: force loop, device and the links both ways."""

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.models.links import Link, Times, delay_ticks, hyperperiod_ticks, serve_phase
from pmwvc_analysis.models.variation import lengths
from pmwvc_core.controllers import has_waves
from pmwvc_core.frame.assembly import force_loop_of
from pmwvc_core.frame.device_sample import DeviceSample
from pmwvc_core.frame.schedule import AT_ONCE, LIVE
from pmwvc_core.master.safety.limiter import SafetyLimiter
from pmwvc_core.numeric import Array, Value, root
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.impedance import Impedance, MatrixImpedance


class Unlimited(SafetyLimiter):
    """Limits that are far away: every force passes."""

    inactive = True

    def step(self, f_asked: Value, *motion: Any) -> Value:
        """Return the force asked for [N]."""
        self.inactive = True
        return f_asked


class Line:
    """One user's end with its device and the links both ways.

    Parameters
    ----------
    index
        Number of the user, from 0.
    ports
        Numbers of its ports at the server: several where it stands for equal users.
    dof
        Axes of the model.
    live
        Whether the phases are those of a live session.

    Attributes
    ----------
    frame, answer, serve
        When it sends, takes an answer, and when the server steps.
    delay
        Both ways together [ticks].
    """

    def __init__(
        self, scenario: Scenario, index: int, *, ports: list[int], dof: int, live: bool
    ) -> None:
        self.user, self.ports, tick_s = scenario.users[index], ports, scenario.tick_s
        user, period_s, schedule = self.user, scenario.server.period_s, LIVE if live else AT_ONCE
        self.name, self.waves = user.name, has_waves(scenario.controller)
        self.loop = force_loop_of(scenario, index, schedule=schedule, dof=dof)
        self.loop.safety = Unlimited(user.safety, tick_s=tick_s, packet_s=period_s)
        self.device = SimulatedDevice(user.device, tick_s=tick_s, dof=dof)
        runs = max(lengths(scenario), default=1)
        if runs > 1:  # signals have the shape of a batch from the first packet on
            self.device.place(np.zeros((1, runs, dof)))
        self.frame = Times(user.master.rate_drop, 0)
        self.answer = Times(user.master.rate_drop, self.loop.frames.answer_tick)
        self.serve = Times(scenario.period_ticks, serve_phase(scenario, live=live))
        up, self._delay_down = delays = [
            delay_ticks(link, tick_s=tick_s, live=live) for link in (user.link_up, user.link_down)
        ]
        self.delay = sum(delays)
        every = Times(1, 0)  # a playout takes packets when they arrive
        read = (every, every) if scenario.strict else (self.serve, self.answer)
        ticks = hyperperiod_ticks(scenario)
        self.up = Link(self.frame, read[0], delay=up, ticks=ticks)
        self.down = Link(self.serve, read[1], delay=self._delay_down, ticks=ticks)

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

    def received_at(self, tick: int) -> int:
        """Return when the answer was sent that the master has at a tick."""
        return self.serve.last(self.answer.last(tick) - self._delay_down)

    @property
    def stiffness(self) -> Array:
        """Stiffness of the contact [N/m], a row per run."""
        return per_run(self.user.contact.contact_stiffness)

    @property
    def tied(self) -> NDArray[np.bool_]:
        """Where a position feedback ties the device to its avatar; a row per run."""
        position = self.user.master.position
        return np.asarray(per_run(position.gain if position.is_on else 0.0) > 0.0)

    @property
    def alone(self) -> NDArray[np.bool_]:
        """Where the contact exerts nothing; a row per run."""
        damping = per_run(self.user.contact.contact_damping)
        return np.asarray((self.stiffness == 0.0) & (damping == 0.0))

    @property
    def braked(self) -> NDArray[np.bool_]:
        """Where the device is damped; a row per run."""
        return np.asarray(per_run(self.user.device.damping) > 0.0)

    @property
    def steady_age(self) -> bool:
        """Whether motion is reported equally late at every step: else the contact is stretched in
        turns, and there is no uniform motion without forces. Waves do not mind.
        """
        return self.waves or len(set(self.up.ages())) == 1

    @property
    def steady_answers(self) -> bool:
        """Whether a position feedback gets the avatar's position equally late at every tick."""
        return self.answer.period == 1 and self.serve.period == 1

    def moves_device(self, xd: Array) -> Array:
        """Return the velocity of the device while the avatar moves with xd, both without a
        force; without waves both are the same.
        """
        return _passed(xd, self.user.server_impedance, self.user.impedance) if self.waves else xd

    def moves_avatar(self, xd: Array) -> Array:
        """Return the velocity of the avatar while the device moves with xd, likewise."""
        return _passed(xd, self.user.impedance, self.user.server_impedance) if self.waves else xd


def _passed(xd: Array, sent: Impedance, received: Impedance) -> Array:
    """Return the velocity that a wave of a velocity makes at a port of another impedance."""
    ends: list[Any] = [
        b if isinstance(b, MatrixImpedance) else per_run(b) for b in (sent, received)
    ]
    return np.asarray(root(ends[0]) * xd / root(ends[1]))


def per_run(value: Value) -> Array:
    """Return a number, or one per run, as a row per run."""
    return np.asarray(value, dtype=float).reshape(-1, 1)


def two_sided(user: User) -> User:
    """Return a user who is in contact, and whose local model is there, all the time."""
    master, contact = user.master, user.contact
    local = dataclasses.replace(master.local_model, acts="everywhere")
    return dataclasses.replace(
        user,
        master=dataclasses.replace(master, local_model=local),
        contact=dataclasses.replace(contact, contact="bilateral"),
    )
