# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user's end in the exact model: controller, device and the links both ways."""

import dataclasses

from pmwvc_analysis.models.links import Link, Packet, Times, answer_phase, delay_ticks
from pmwvc_core.controllers import has_waves, make_master
from pmwvc_core.master.brake import brake_of
from pmwvc_core.numeric import Value
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.transport.packet import Packer, WavePacket
from pmwvc_core.wave.playout import Playout

AMPLE_J = 1.0  # beside a wave of 2^-40: the account never binds
NUMBERED = 1 << 24  # of the packet sent at tick 0


class Line:
    """One user's end with its device and the links both ways.

    Parameters
    ----------
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
        # On the strict channel: of the wave up at the server, and of the wave down at the device.
        self.played_up, self.played_down = (
            Playout(most_repaid=1.0) if scenario.strict else None for _ in range(2)
        )
        self._packer = Packer(1, period=user.master.frame_s)
        self.controller = make_master(
            scenario.controller,
            user.master,
            user.baseline,
            strict=(self.played_down, self._packer, brake_of(user.master))
            if self.played_down
            else None,
        )
        self.device = SimulatedDevice(user.device, tick_s=tick_s, dof=dof)
        self.frame, self.serve = Times(frame, 0), serve
        self.answer = Times(frame, answer_phase(user, live=live))
        up, self._delay_down = (
            delay_ticks(link, tick_s=tick_s, live=live) for link in (user.link_up, user.link_down)
        )
        every = Times(1, 0)  # a playout takes packets when they arrive
        read = (every, every) if scenario.strict else (serve, self.answer)
        self.up = Link(self.frame, read[0], delay=up, ticks=ticks)
        self.down = Link(serve, read[1], delay=self._delay_down, ticks=ticks)

    def send(self, tick: int) -> None:
        """Send the packet of a frame start."""
        controller = self.controller
        controller.measure(*self.device.read())
        self.up.send(tick, (controller.send(), controller.position()))
        self._packer.seq += 1

    @property
    def playouts(self) -> dict[str, Playout]:
        """The playouts of the strict channel by their prefix."""
        ways = (("up", self.played_up), ("down", self.played_down))
        return {f"{self.name}.{way}.played.": each for way, each in ways if each is not None}

    def play(self, tick: int, *, down: bool) -> None:
        """Give what arrives to the playout of one way, with energy for whatever it does."""
        link, played = (self.down, self.played_down) if down else (self.up, self.played_up)
        period_s = self._period_s if down else self.user.master.frame_s
        packet = link.arrived(tick)
        if played is not None and packet is not None:
            played.add(packet[0] * period_s, AMPLE_J, period_s)

    def received(self, tick: int) -> Packet:
        """Return the packet that the server uses in its step."""
        if self.played_up is None:
            return self.up.take(tick)[1]
        return self.played_up.step(self._period_s), 0.0

    def receive(self, tick: int) -> None:
        """Hand the newest answer to the controller."""
        number, (wave, position) = self.down.take(tick)
        self.controller.on_packet(
            WavePacket(
                1, NUMBERED + number, 0, self._period_s, wave, 0.0, 0.0, position, self._packer.seq
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
