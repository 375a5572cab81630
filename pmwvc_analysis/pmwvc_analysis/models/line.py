# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user's end in the exact model: controller, device and the links both ways."""

import dataclasses

from pmwvc_analysis.models.links import Link, Times, answer_phase, delay_ticks
from pmwvc_core.controllers import has_waves, make_master
from pmwvc_core.numeric import Value
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.transport.packet import WavePacket

NUMBERED = 1 << 24  # of the packet sent at tick 0


class Line:
    """One user's end with its device and the links both ways.

    Parameters
    ----------
    user, scenario
        Parameters.
    serve
        When the server steps.
    dof, ticks
        Number of axes; length of the hyperperiod.
    live
        Whether the phases are those of a live session.
    """

    def __init__(
        self, user: User, scenario: Scenario, *, serve: Times, dof: int, ticks: int, live: bool
    ) -> None:
        tick_s, frame = scenario.tick_s, user.master.rate_drop
        self.waves = has_waves(scenario.controller)
        self.user, self.name, self._period_s = user, user.name, scenario.server.period_s
        self.controller = make_master(scenario.controller, user.master, user.baseline)
        self.device = SimulatedDevice(user.device, tick_s=tick_s, dof=dof)
        self.frame, self.serve = Times(frame, 0), serve
        self.answer = Times(frame, answer_phase(user, live=live))
        up, self._delay_down = (
            delay_ticks(link, tick_s=tick_s, live=live) for link in (user.link_up, user.link_down)
        )
        self.up = Link(self.frame, serve, delay=up, ticks=ticks)
        self.down = Link(serve, self.answer, delay=self._delay_down, ticks=ticks)
        self._sent = 0

    def send(self, tick: int) -> None:
        """Send the packet of a frame start."""
        controller = self.controller
        controller.measure(*self.device.read())
        self._sent += 1
        self.up.send(tick, (controller.send(), controller.position()))

    def receive(self, tick: int) -> None:
        """Hand the newest answer to the controller."""
        number, (wave, position) = self.down.take(tick)
        self.controller.on_packet(
            WavePacket(
                1, NUMBERED + number, 0, self._period_s, wave, 0.0, 0.0, position, self._sent
            )
        )
        self.controller.receive(wave)

    def step(self, f_h: Value) -> tuple[Value, Value, Value]:
        """Go one tick on; return x, xd and the controller's force at its start."""
        x, xd = self.device.read()
        force = self.controller.step(x, xd)
        self.controller.applied(force)
        self.device.step(f_h, force)
        return x, xd, force

    def received_at(self, tick: int) -> int:
        """Return when the answer was sent that the master has at a tick."""
        return self.serve.last(self.answer.last(tick) - self._delay_down)


def two_sided(user: User) -> User:
    """Return a user who is in contact, and whose local model is there, all the time."""
    master, contact = user.master, user.contact
    local = dataclasses.replace(master.local_model, acts="everywhere")
    return dataclasses.replace(
        user,
        master=dataclasses.replace(master, local_model=local),
        contact=dataclasses.replace(contact, contact="bilateral"),
    )
