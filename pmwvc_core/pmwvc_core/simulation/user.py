# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""One user in virtual time: device, hand, client, and the paths both ways."""

from collections.abc import Sequence

import numpy as np

from pmwvc_core.controllers import has_waves, make_master
from pmwvc_core.master.client import Client
from pmwvc_core.master.safety import SafetyLimiter
from pmwvc_core.network.link import stream_of
from pmwvc_core.numeric import Value
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.plant.operators import Operator, make_operator
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.event_schedule import Loop
from pmwvc_core.simulation.links import SimulatedLink
from pmwvc_core.simulation.stacking import stack
from pmwvc_core.transport.inboxes import inbox, server_times
from pmwvc_core.transport.packet import Packer
from pmwvc_core.wave.impedance import Impedance
from pmwvc_core.wave.limits import largest_wave


class SimulatedUser:
    """One user in the simulator.

    Parameters
    ----------
    users, scenarios
        This user in every run of the batch, and the runs' scenarios.
    index
        Place of the user, from 0.
    conditions
        What does not come from the scenario.
    """

    def __init__(
        self,
        users: Sequence[User],
        scenarios: Sequence[Scenario],
        index: int,
        conditions: Conditions,
    ) -> None:
        first, scenario = users[0], scenarios[0]
        dof, tick_s, name = scenario.dof, scenario.tick_s, first.name
        master, safety = stack([u.master for u in users]), stack([u.safety for u in users])
        contact, server = stack([u.contact for u in users]), stack([s.server for s in scenarios])
        self.settings = first
        self.loop = Loop(
            first.master.rate_drop,
            first=conditions.first.get(name, 0),
            answer=min(conditions.phases.answer_ticks, first.master.rate_drop - 1),
            ran_ns=conditions.ran_ns.get(name),
        )
        # As live: packets come in at every tick, and the hand begins the tick after an answer.
        self._listens = conditions.phases.answer_ticks > 0
        self._coupled = False
        self._acts = False
        frame_s = first.master.frame_s
        half = server.object_size_m / 2
        start = first.side * (half + contact.gap_m)
        times = server_times(user.safety for user in scenario.users)
        waves = has_waves(scenario.controller)
        up, down = (conditions.links.get(f"{name}/{way}") for way in ("up", "down"))
        self.up = SimulatedLink(
            up() if up else first.link_up,
            seed=stream_of(scenario.seed, index, 0),
            inbox=inbox(
                dof,
                _loosest([user.server_impedance for user in users], waves=waves),
                waves=waves,
                period_s=frame_s,
                timeout_s=times.timeout_s,
            ),
            dof=dof,
        )
        self.down = SimulatedLink(
            down() if down else first.link_down,
            seed=stream_of(scenario.seed, index, 1),
            inbox=inbox(
                dof,
                _loosest([user.impedance for user in users], waves=waves),
                waves=waves,
                period_s=server.period_s,
                timeout_s=first.safety.timeout_s,
            ),
            dof=dof,
        )
        self.client = Client(
            make_master(scenario.controller, master, stack([user.baseline for user in users])),
            SafetyLimiter(safety, tick_s=tick_s, packet_s=server.period_s),
            inbox=self.down.receiver,
            packer=Packer(index + 1, period=frame_s),
        )
        self.device = SimulatedDevice(stack([u.device for u in users]), tick_s=tick_s, dof=dof)
        # In a batch every run has a place of its own from the beginning.
        self.device.place(start + np.zeros((len(users), 1)) if len(users) > 1 else start)
        hand = conditions.hands.get(name)
        self.operator: Operator = (
            hand()
            if hand
            else make_operator(
                stack([u.operator for u in users]),
                scenario.task,
                side=first.side,
                half_width=half,
                tick_s=tick_s,
                dof=dof,
                start=start,
            )
        )
        self.f_applied: Value = 0.0

    def send(self, now_ns: int) -> None:
        """Send the packet of a frame start."""
        self.client.controller.measure(*self.device.read())
        self.up.send(self.client.send(now_ns), now_ns)

    def answer(self, now_ns: int) -> None:
        """Hand the newest answer to the controller, once a frame."""
        self._listen(now_ns)
        self.client.receive(now_ns)
        self._coupled = self._coupled or self.client.ready()

    def _listen(self, now_ns: int) -> None:
        for packet in self.down.collect(now_ns):
            self.down.receiver.push(packet, now_ns)

    def advance(self, times_ns: Sequence[int]) -> list[Value]:
        """Go on tick by tick, in between two events of the network.

        Returns
        -------
        list
            Signals tick by tick, in the order of ``buffers.SIGNALS``.
        """
        device, client, port = self.device, self.client, self.client.controller
        operator = self.operator
        due_ns = self.down.link.next_due_ns if self._listens else None
        comes = due_ns is not None and due_ns <= times_ns[-1]
        f_applied, acts = self.f_applied, self._acts
        values: list[Value] = []
        x, xd = device.read()
        for now_ns in times_ns:
            if comes:
                self._listen(now_ns)
            if not acts:
                self._acts = acts = not self._listens and client.ready()
            # The hand is in touch with the device itself, not with its encoder.
            f_h = operator.step(device.x, device.xd) if acts else operator.hold()
            if self._coupled:
                self._acts = acts = True
            f_applied = client.step(x, xd, now_ns)
            measured = device.step(f_h, f_applied)
            values += (x, xd, f_h, client.f_asked, f_applied, port.u_m, port.u_m_lp, port.v_m)
            x, xd = measured
        self.f_applied = f_applied
        return values

    def pass_by(self) -> None:
        """Let a tick pass that the force loop missed: the last force stays on the device."""
        device, operator = self.device, self.operator
        f_h = operator.step(device.x, device.xd) if self._acts else operator.hold()
        device.step(f_h, self.f_applied)


def _loosest(impedances: Sequence[Impedance], *, waves: bool) -> Impedance:
    """Return the impedance of the run whose waves may be longest."""
    return max(impedances, key=lambda impedance: largest_wave(impedance, waves=waves))
