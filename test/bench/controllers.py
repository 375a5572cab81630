# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Compute of every controller: a tick of the master and a step of the server, in one process.

Two force loops and a server are coupled without a network, receivers and limits included; the
devices go to and fro as prescribed, in and out of contact, so that every branch of a controller
has its turn. Every case is on the plain channel, which refuses none of them. Each number stands
beside the wave controller on one axis, measured in the same run.

``python test/bench/controllers.py`` prints the table alone.
"""

import math
import time
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table

from pmwvc_bringup.scenarios import load
from pmwvc_core.ends.inbox import value
from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.frame import DeviceSample
from pmwvc_core.scenario.scenario import Scenario

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
    """CPU time [us] of a force loop's tick and of a server's step with two users."""

    tick_us: float
    step_us: float


class Session:
    """Both ends of a scenario without a network, stepped and timed."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario, self.tick = scenario, 0
        self.loops = [UserEnd(user, scenario, epoch=i) for i, user in enumerate(scenario.users, 1)]
        self.server = ServerEnd(scenario)

    def run(self, frames: int) -> Compute:
        """Return the compute of some frames, on average."""
        rate_drop = self.scenario.users[0].master.rate_drop
        of_loops = of_server = 0
        for _ in range(frames):
            motions = [
                [self._motion(i, self.tick + n) for n in range(rate_drop)]
                for i in range(len(self.loops))
            ]
            begin, now_ns = time.process_time_ns(), self._now_ns(self.tick)
            packets = [
                loop.start_frame(self.tick, now_ns, motion[0])
                for loop, motion in zip(self.loops, motions, strict=True)
            ]
            asked = time.process_time_ns()
            answers, _ = self.server.tick(now_ns, [[p] for p in packets if p is not None])
            answered = time.process_time_ns()
            for loop, answer, motion in zip(self.loops, answers, motions, strict=True):
                came = [answer] if answer is not None else []
                for n, sample in enumerate(motion):
                    tick = self.tick + n
                    loop.tick(tick, self._now_ns(tick), sample, [] if n else came)
            end = time.process_time_ns()
            self.tick += rate_drop
            of_loops += (asked - begin) + (end - answered)
            of_server += answered - asked
        ticks = frames * rate_drop * len(self.loops)
        return Compute(of_loops * 1e-3 / ticks, of_server * 1e-3 / frames)

    def _now_ns(self, tick: int) -> int:
        return round(tick * self.scenario.tick_s * 1e9)

    def _motion(self, i: int, tick: int) -> DeviceSample:
        """Return where a device is and how fast: 5 mm to and fro, and sideways."""
        user, dof = self.scenario.users[i], self.scenario.dof
        time_s = tick * user.master.tick_s
        start = user.side * (self.scenario.server.object_size_m / 2)
        rates = [RATE_RAD_S * (1.0 + 0.3 * axis) for axis in range(dof)]
        x = [WAY_M * (1.0 - math.cos(w * time_s)) * -user.side for w in rates]
        xd = [WAY_M * w * math.sin(w * time_s) * -user.side for w in rates]
        x[0] += start
        return DeviceSample(value(tuple(x)), value(tuple(xd)))


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
