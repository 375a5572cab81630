# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Compute of every controller: a tick of the master and a step of the server, in one process.

Two masters and a server are coupled without a network; the devices go to and fro as prescribed, in
and out of contact, so that every branch of a controller has its turn. The work of a channel is not
in these numbers, so every case is on the plain one, which refuses none of them. Each number stands
beside the wave controller on one axis, measured in the same run.

``python test/bench/controllers.py`` prints the table alone.
"""

import math
import time
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table

from pmwvc_bringup.scenarios import load
from pmwvc_core.controllers.ends import make_master, make_server
from pmwvc_core.numeric import Value, signal
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.transport.packet import FLAG_DIRECT, Packer, WavePacket
from pmwvc_core.wave.impedance import server_impedance

FRAMES, REPEATS = 125, 5  # a second each
WAY_M, RATE_RAD_S = 0.0025, 2.0 * math.pi
COLUMNS = ("tick, one axis", "step, one axis", "tick, three axes", "step, three axes")
REFERENCE = "pmwvc"
BANK = "master.bank.kind"
FILTER = "master.velocity_filter.kind"
FEEDBACK = "master.position.feedback"
UNKNOWN = "server.coupling=unknown"
CASES = {
    REFERENCE: [],
    "direct": ["controller=direct"],
    "virtual_coupling": ["controller=virtual_coupling"],
    "tdpa": ["controller=tdpa"],
    "pspm": ["controller=pspm"],
    "velocity filter: equivalent": [f"{FILTER}=equivalent"],
    "velocity filter: exact": [f"{FILTER}=exact"],
    "velocity filter: complementary": [f"{FILTER}=complementary"],
    "bank: dissertation": [f"{BANK}=dissertation", "master.local_model.stiffness=500.0"],
    "bank: complementary": [f"{BANK}=complementary", "master.local_model.stiffness=500.0"],
    "position feedback: printed": [f"{FEEDBACK}=printed", "master.position.gain=10.0"],
    "position feedback: budgeted": [f"{FEEDBACK}=budgeted", "master.position.gain=10.0"],
    "position feedback: integral": [f"{FEEDBACK}=integral", "master.position.gain=10.0"],
    "filter, bank and feedback": [
        f"{FILTER}=exact",
        f"{BANK}=dissertation",
        "master.local_model.stiffness=500.0",
        "master.position.gain=10.0",
    ],
    "Butterworth filter": [
        "master.filter.kind=butterworth",
        "master.filter.stop_hz=50.0",
        "master.hold=zoh",
    ],
    "coupling: one_step_delay": ["server.coupling=one_step_delay"],
    "coupling: one_frame_late": ["server.coupling=one_frame_late"],
    "coupling: unwrapped": ["server.coupling=unwrapped"],
    "unknown, compensation: none": [UNKNOWN, "server.compensation=none"],
    "unknown, compensation: printed": [UNKNOWN, "server.compensation=printed"],
    "unknown, compensation: corrected": [UNKNOWN, "server.compensation=corrected"],
    "unknown, compensation: ledger": [UNKNOWN, "server.compensation=ledger"],
    "unknown: wall_with_slope": [UNKNOWN, "server.environment=wall_with_slope"],
    "unknown: hunt_crossley": [UNKNOWN, "server.environment=hunt_crossley"],
    "unknown: active_wall": [UNKNOWN, "server.environment=active_wall"],
}
THREE = ["dof=3"]
MATRIX = [*THREE, "master.impedance_matrix=30 6 0; 6 20 4; 0 4 25"]


@dataclass(frozen=True)
class Compute:
    """CPU time [us] of a master's tick and of a server's step with two users."""

    tick_us: float
    step_us: float


class Session:
    """Both ends of a scenario without a network, stepped and timed."""

    def __init__(self, scenario: Scenario) -> None:
        users = scenario.users
        self.scenario = scenario
        self.masters = [
            make_master(scenario.controller, user.master, user.baseline) for user in users
        ]
        self.server = make_server(
            scenario.controller,
            scenario.server,
            [user.contact for user in users],
            [server_impedance(user.contact, user.master) for user in users],
            dof=scenario.dof,
            sides=[user.side for user in users],
            baselines=[user.baseline for user in users],
        )
        self.direct = bool(self.server.flags & FLAG_DIRECT)
        self.up = [Packer(1, period=user.master.frame_s) for user in users]
        self.down = [Packer(2, period=scenario.server.period_s) for _ in users]
        self.tick = 0
        for i in range(len(users)):
            self.server.join(i, self._motion(i, 0)[0])

    def run(self, frames: int) -> Compute:
        """Return the compute of some frames, on average."""
        rate_drop = self.scenario.users[0].master.rate_drop
        of_masters = of_server = 0
        for _ in range(frames):
            begin = time.process_time_ns()
            waves = [self._sent(i) for i in range(len(self.masters))]
            sent = time.process_time_ns()
            packets = [
                self._packed(packer, wave, master.position(), master.account())
                for packer, wave, master in zip(self.up, waves, self.masters, strict=True)
            ]
            asked = time.process_time_ns()
            for i, packet in enumerate(packets):
                self.server.on_packet(i, packet)
            answers = self.server.step(
                [(p.position, p.wave) if self.direct else p.wave for p in packets]
            )
            answered = time.process_time_ns()
            replies = [
                self._packed(packer, answer, x_s, port.account)
                for packer, answer, x_s, port in zip(
                    self.down, answers, self.server.x_s, self.server.ports, strict=True
                )
            ]
            motions = [
                [self._motion(i, self.tick + n) for n in range(rate_drop)]
                for i in range(len(self.masters))
            ]
            heard = time.process_time_ns()
            for master, reply, motion in zip(self.masters, replies, motions, strict=True):
                master.on_packet(reply)
                master.receive(reply.wave)
                for x, xd in motion:
                    master.applied(master.step(x, xd))
            end = time.process_time_ns()
            self.tick += rate_drop
            of_masters += (sent - begin) + (end - heard)
            of_server += answered - asked
        ticks = frames * rate_drop * len(self.masters)
        return Compute(of_masters * 1e-3 / ticks, of_server * 1e-3 / frames)

    def _sent(self, i: int) -> Value:
        self.masters[i].measure(*self._motion(i, self.tick))
        return self.masters[i].send()

    def _packed(
        self, packer: Packer, wave: Value, position: Value, energy: Value | None
    ) -> WavePacket:
        return packer.pack(wave, position, self.tick, energy=energy)

    def _motion(self, i: int, tick: int) -> tuple[Value, Value]:
        """Return where a device is and how fast: 5 mm to and fro, and sideways."""
        user, dof = self.scenario.users[i], self.scenario.dof
        time_s = tick * user.master.tick_s
        start = user.side * (self.scenario.server.object_size_m / 2)
        rates = [RATE_RAD_S * (1.0 + 0.3 * axis) for axis in range(dof)]
        x = [WAY_M * (1.0 - math.cos(w * time_s)) * -user.side for w in rates]
        xd = [WAY_M * w * math.sin(w * time_s) * -user.side for w in rates]
        x[0] += start
        return signal(x, dof), signal(xd, dof)


def scenario_of(settings: list[str]) -> Scenario:
    """Return the scenario of a case."""
    return load("carry_16ms", settings_texts=["channel=plain", *settings])


def measure(settings: list[str]) -> Compute:
    """Return the shortest of some repeats, each for itself."""
    session = Session(scenario_of(settings))
    found = [session.run(FRAMES) for _ in range(REPEATS)]
    return Compute(min(each.tick_us for each in found), min(each.step_us for each in found))


def bench_controllers() -> tuple[Table, dict[str, dict[str, float]]]:
    """Return the table and the numbers [us] of every case on one axis and on three."""
    one = {name: measure(settings) for name, settings in CASES.items()}
    three = {name: measure([*settings, *THREE]) for name, settings in CASES.items()}
    three["matrix impedance"] = measure(MATRIX)
    plain = one[REFERENCE]
    table = Table("controller", *COLUMNS, title=f"compute beside {REFERENCE} on one axis")
    numbers: dict[str, dict[str, float]] = {}
    for name in three:
        cells = []
        for axes, found in (("one", one.get(name)), ("three", three[name])):
            if found is None:
                cells += ["-", "-"]
                continue
            cells += [
                f"{found.tick_us:5.1f} us {found.tick_us / plain.tick_us:5.2f}",
                f"{found.step_us:5.1f} us {found.step_us / plain.step_us:5.2f}",
            ]
            numbers.setdefault(name, {}).update(
                {f"tick_us_{axes}": found.tick_us, f"step_us_{axes}": found.step_us}
            )
        table.add_row(name, *cells)
    return table, numbers


if __name__ == "__main__":
    Console(width=110).print(bench_controllers()[0])
