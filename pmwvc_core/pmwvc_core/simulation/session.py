# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The session in virtual time: the live system's own objects, stepped in the order of a frame.

1. Frame start: every master sends the filter's output of its last tick. 2. The server uses what
has arrived and answers. 3. Every master takes the newest answer. 4. M ticks. With zero delay a
packet arrives at the instant it was sent, so 1 to 3 are one instant.

Deterministic: the same scenario gives the same bits. Batched: scenarios of equal structure are
stepped together on arrays ``(runs, dof)``; a single run with one axis is stepped on floats, as the
live loop is.
"""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from pmwvc_core.controllers import make_master, make_server
from pmwvc_core.master.client import Client
from pmwvc_core.master.safety import SafetyLimiter
from pmwvc_core.network.link import stream_of
from pmwvc_core.numeric import Value, dot
from pmwvc_core.params import whole_ratio
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.plant.operators import make_operator
from pmwvc_core.plant.task import ShownTarget, Task
from pmwvc_core.server.service import Service
from pmwvc_core.simulation.buffers import (
    ServerBuffer,
    UserBuffer,
    fate_traces,
    packet_traces,
)
from pmwvc_core.simulation.paths import Path
from pmwvc_core.simulation.scenario import Scenario, User
from pmwvc_core.simulation.stacking import batches, stack
from pmwvc_core.simulation.traces import SessionTraces
from pmwvc_core.wave.packet import Packer

R = TypeVar("R")
LARGEST_BATCH = 256  # bounds the memory of the traces: about 90 MB per user and ten seconds
SERVER_EPOCH = 1000  # epochs are random in live sessions, where a process can start again


def simulate_one(scenario: Scenario) -> SessionTraces:
    """Simulate one scenario."""
    return simulate([scenario])[0]


def simulate(
    scenarios: Sequence[Scenario],
    *,
    keep: Callable[[SessionTraces], R] | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[R] | list[SessionTraces]:
    """Simulate scenarios, those of equal structure side by side.

    Parameters
    ----------
    scenarios
        What to run; results come in the same order.
    keep
        What to keep of each run (its verdict, say); all traces by default.
    progress
        Called with the share done, 0..1.
    """
    results: list[Any] = [None] * len(scenarios)
    done = 0
    for members in batches(scenarios, largest=LARGEST_BATCH):
        batch = SessionBatch([scenarios[i] for i in members])

        def report(share: float, *, before: int = done, size: int = len(members)) -> None:
            if progress is not None:
                progress((before + share * size) / len(scenarios))

        batch.run(report)
        for run, position in enumerate(members):
            traces = batch.traces(run)
            results[position] = traces if keep is None else keep(traces)
        done += len(members)
    return results


class _Seat:
    """One user in the simulator: device, hand, client, and the paths both ways."""

    def __init__(self, users: Sequence[User], scenarios: Sequence[Scenario], index: int) -> None:
        first, scenario = users[0], scenarios[0]
        dof, tick_s = scenario.dof, scenario.tick_s
        master, safety = stack([u.master for u in users]), stack([u.safety for u in users])
        contact, server = stack([u.contact for u in users]), stack([s.server for s in scenarios])
        self.user = first
        self.rate_drop = first.master.rate_drop
        frame_s = first.master.frame_s
        half = server.object_size_m / 2
        start = first.side * (half + contact.gap_m)
        timeout_s = first.safety.timeout_s
        self.up = Path(
            first.link_up,
            seed=stream_of(scenario.seed, index, 0),
            period_s=frame_s,
            timeout_s=timeout_s,
            dof=dof,
        )
        self.down = Path(
            first.link_down,
            seed=stream_of(scenario.seed, index, 1),
            period_s=server.period_s,
            timeout_s=timeout_s,
            dof=dof,
        )
        self.client = Client(
            make_master(scenario.controller, master),
            SafetyLimiter(safety, tick_s=tick_s, packet_s=server.period_s),
            inbox=self.down.receiver,
            packer=Packer(index + 1, period=frame_s),
        )
        self.device = SimulatedDevice(stack([u.device for u in users]), tick_s=tick_s, dof=dof)
        self.device.place(start)
        self.operator = make_operator(
            stack([u.operator for u in users]),
            scenario.task,
            side=first.side,
            half_width=half,
            tick_s=tick_s,
            dof=dof,
            start=start,
        )
        self.energy_device: Value = 0.0
        self.energy_hand: Value = 0.0

    def tick(self, now_ns: int, tick_s: float) -> dict[str, Value]:
        """Advance hand, controller and device by one tick; return the signals to trace."""
        x, xd = self.device.read()
        # The hand is in touch with the device itself, not with what its encoder shows.
        acts = self.client.ready()
        f_h = self.operator.step(self.device.x, self.device.xd) if acts else self.operator.hold()
        f_applied = self.client.step(x, xd, now_ns)
        self.energy_device = self.energy_device + dot(f_applied, xd) * tick_s
        self.energy_hand = self.energy_hand + dot(f_h, xd) * tick_s
        self.device.step(f_h, f_applied)
        port = self.client.controller
        return {
            "x_m": x,
            "xd_m": xd,
            "f_h": f_h,
            "f_m": self.client.f_asked,
            "f_applied": f_applied,
            "u_m": port.u_m,
            "u_m_lp": port.u_m_lp,
            "v_m": port.v_m,
        }


class SessionBatch:
    """Scenarios of equal structure, stepped together."""

    def __init__(self, scenarios: Sequence[Scenario]) -> None:
        first = scenarios[0]
        self.scenarios = list(scenarios)
        self.tick_s = first.tick_s
        self.tick_ns = round(first.tick_s * 1e9)
        self.ticks = round(first.duration_s / first.tick_s)
        self.server_ticks = whole_ratio(first.server.period_s, first.tick_s) or 1
        self.seats = [
            _Seat([s.users[i] for s in scenarios], scenarios, i) for i in range(len(first.users))
        ]
        self.target = ShownTarget(
            Task(first.task),
            period_s=first.server.period_s,
            soft_start_s=max(user.safety.soft_start_s for user in first.users),
        )
        server = make_server(
            first.controller,
            stack([s.server for s in scenarios]),
            [stack([s.users[i].contact for s in scenarios]) for i in range(len(self.seats))],
            [_impedance([s.users[i] for s in scenarios]) for i in range(len(self.seats))],
            dof=first.dof,
            sides=[seat.user.side for seat in self.seats],
        )
        self.service = Service(
            server,
            inboxes=[seat.up.receiver for seat in self.seats],
            packers=[
                Packer(SERVER_EPOCH + i, period=first.server.period_s)
                for i in range(len(self.seats))
            ],
        )
        runs, dof, names = len(scenarios), first.dof, [seat.user.name for seat in self.seats]
        steps = -(-self.ticks // self.server_ticks)
        self.server_buffer = ServerBuffer(names, steps=steps, runs=runs, dof=dof)
        self.user_buffers = [
            UserBuffer(
                seat.user.name,
                ticks=self.ticks,
                blocks=-(-self.ticks // seat.rate_drop),
                runs=runs,
                dof=dof,
            )
            for seat in self.seats
        ]

    def run(self, progress: Callable[[float], None]) -> None:
        """Step from the first tick to the last."""
        for tick in range(self.ticks):
            self._frame_events(tick, tick * self.tick_ns)
            for seat, buffer in zip(self.seats, self.user_buffers, strict=True):
                buffer.write_tick(tick, **seat.tick(tick * self.tick_ns, self.tick_s))
                if (tick + 1) % seat.rate_drop == 0 or tick + 1 == self.ticks:
                    self._note(seat, buffer, tick // seat.rate_drop)
            if tick % 1000 == 0:
                progress(tick / self.ticks)
        progress(1.0)

    def _frame_events(self, tick: int, now_ns: int) -> None:
        """Send, serve and receive, where this tick starts a frame."""
        for seat in self.seats:
            if tick % seat.rate_drop == 0:
                seat.client.controller.measure(*seat.device.read())
                seat.up.send(seat.client.send(now_ns), now_ns)
        if tick % self.server_ticks == 0:
            for user, seat in enumerate(self.seats):
                for packet in seat.up.collect(now_ns):
                    self.service.deliver(user, packet, now_ns)
            for seat, answer in zip(self.seats, self.service.step(now_ns), strict=True):
                if answer is not None:
                    seat.down.send(answer, now_ns)
            target = self.target.step(together=self.service.together())
            step = tick // self.server_ticks
            self.server_buffer.write(step, self.service.server, self.service.presence, target)
        for seat in self.seats:
            if tick % seat.rate_drop == 0:
                for packet in seat.down.collect(now_ns):
                    seat.down.receiver.push(packet, now_ns)
                seat.client.receive(now_ns)

    def _note(self, seat: _Seat, buffer: UserBuffer, block: int) -> None:
        port, safety = seat.client.controller, seat.client.safety
        buffer.write_block(
            block,
            safety.state,
            safety.reason,
            u_m=port.energy_u_m,
            u_tx=port.energy_u_tx,
            v_rx=port.energy_v_rx,
            v_m=port.energy_v_m,
            device=seat.energy_device,
            hand=seat.energy_hand,
        )

    def traces(self, run: int) -> SessionTraces:
        """Return what one run of the batch leaves behind."""
        scenario = self.scenarios[run]
        traces = SessionTraces(
            source="simulated",
            duration_s=self.ticks * self.tick_s,
            users=[
                buffer.run(
                    run,
                    tick_s=self.tick_s,
                    block_ticks=seat.rate_drop,
                    safety_events=_of_run(seat.client.safety.events, run),
                )
                for seat, buffer in zip(self.seats, self.user_buffers, strict=True)
            ],
            server=self.server_buffer.run(run, period_s=scenario.server.period_s),
        )
        for seat in self.seats:
            self._network_traces(traces, seat, run)
        return traces

    def _network_traces(self, traces: SessionTraces, seat: _Seat, run: int) -> None:
        """Add the packets on both sides of the network, and their fates."""
        name, runs, dof = seat.user.name, len(self.scenarios), self.scenarios[0].dof
        for way, path, sender, receiver in (
            ("up", seat.up, f"/{name}", f"/server/{name}"),
            ("down", seat.down, f"/server/{name}", f"/{name}"),
        ):
            sent = [(packet, packet.sent_ns) for packet in path.sent]
            for seen, side in ((sent, sender), (path.arrived, receiver)):
                topic = f"{side}/wave_{way}"
                packets = packet_traces(seen, topic, run=run, runs=runs, dof=dof)
                traces.packets[topic] = packets
                traces.counts[topic] = {"messages": len(packets.seq), "missing": 0}
            traces.fates[f"{name}/{way}"] = fate_traces(path, f"{name}/{way}")


def _impedance(users: Sequence[User]) -> Value:
    """Return the wave impedance of a user's server port, an array where the runs differ."""
    values = [user.server_impedance for user in users]
    if all(value == values[0] for value in values):
        return values[0]
    return np.array(values)[:, np.newaxis]


def _of_run(value: object, run: int) -> int:
    """Return one run's entry of a count that a batch may hold as an array."""
    return int(value[run, 0]) if isinstance(value, np.ndarray) else int(value)  # type: ignore[call-overload]
