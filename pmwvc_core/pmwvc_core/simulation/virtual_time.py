# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A user in virtual time: device, hand, force loop, the links both ways, and notes of its ticks,
which come on their grid, or where the loop of a recorded session ran.
"""

from array import array
from collections.abc import Sequence
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from pmwvc_core.ends.user_end import CATCH_UP_S, DevicePlant, UserEnd
from pmwvc_core.frame import SIGNALS, FrameReport
from pmwvc_core.numeric import Value
from pmwvc_core.plant.hands import make_hand
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.simulation.conditions import Conditions, Ticks, columns, place_of
from pmwvc_core.traces import ENERGIES, UserTraces
from pmwvc_core.transport.packet import WavePacket
from pmwvc_core.transport.receiver import Receiver


class TickNotes:
    """Notes of a user's ticks."""

    def __init__(self) -> None:
        self.ticks: list[int] = []  # that ran, and when [ns]
        self.times_ns: list[int] = []
        self.signals = array("d")  # tick by tick, in the order of ``SIGNALS``
        # Frames that ended: before which tick, report, ``ENERGIES`` [J], those with changes.
        self.frames: list[tuple[int, FrameReport, list[Value], int]] = []


class SimulatedUser:
    """The user with a number (from 0), in a session of so many ticks, with its server's inbox."""

    def __init__(
        self, scenario: Scenario, index: int, ticks: int, inbox: Receiver, conditions: Conditions
    ) -> None:
        self.settings = user = scenario.users[index]
        self.loop = UserEnd(user, scenario, epoch=index + 1, schedule=conditions.schedule)
        self.up = conditions.link_of(scenario, index, 0, inbox)
        self.down = conditions.link_of(scenario, index, 1, self.loop.inbox)
        at, name = place_of(user, scenario), user.name
        hand = conditions.hands.get(name) or make_hand(user.operator, scenario.task, at)
        self.device = DevicePlant(user.device, hand, at.start, tick_s=at.tick_s)
        first, ran_ns = conditions.first.get(name, 0), conditions.ran_ns.get(name)
        self.ticks = Ticks(first, ran_ns, ticks, round(scenario.tick_s * 1e9))
        self.notes, self._dof = TickNotes(), scenario.dof
        self._catch_up = max(1, round(CATCH_UP_S / scenario.tick_s))
        # As live: the hand begins the tick after an answer.
        self._live = conditions.schedule.answer_s > 0.0
        self._acts = False
        self._f: Value = 0.0  # of the last tick [N]

    def change(self, old: User, new: User) -> None:
        """Hand over the groups of parameters that differ to the loop and the links."""
        both = {n: (getattr(old, n), getattr(new, n)) for n in ("master", "given_safety")}
        if groups := {name: other for name, (one, other) in both.items() if other != one}:
            self.loop.hand_over(partial(self.loop.configure, **groups))
        if new.link_up != old.link_up:
            self.up.configure(new.link_up)
        if new.link_down != old.link_down:
            self.down.configure(new.link_down)

    def send(self, until_ns: int) -> bool:
        """Send the packet of a frame that starts by then [ns]; tell whether a tick is due."""
        ticks = self.ticks
        if not (ticks.next < len(ticks.at_ns) and ticks.at_ns[ticks.next] <= until_ns):
            return False
        for _ in ticks.passing(self._catch_up):
            self.device.sense(self._acts)
            self.device.step(self._f)
        number, now_ns = ticks.ran[ticks.next] - ticks.first, ticks.at_ns[ticks.next]
        packet = self.loop.start_frame(number, now_ns, self.device.sample)
        if packet is not None:
            self.up.send(packet, now_ns)
        return True

    def run(self, before_ns: int) -> None:
        """Run the ticks that are due before an instant [ns]; note energies where a frame ends."""
        while self.send(before_ns - 1):
            ends = self.ticks.first + self.loop.s.next_frame
            taken, over = self.ticks.take(before_ns, ends)
            ticks, times_ns = self.ticks.ran[taken], self.ticks.at_ns[taken]
            self.notes.ticks += ticks
            self.notes.times_ns += times_ns
            values = self._advance(ticks, times_ns)
            self.notes.signals.frombytes(columns(values, self._dof).tobytes())
            if over:
                report, device = self.loop.report(), self.device.s
                sums = [*report[2:6], device.against_j, device.by_hand_j]
                self.notes.frames.append((ends, report, sums, self.loop.changes))

    def _advance(self, ticks: Sequence[int], times_ns: Sequence[int]) -> list[Value]:
        device, loop = self.device, self.loop
        first, acts = self.ticks.first, self._acts
        packets: Sequence[WavePacket] = ()
        due_ns = self.down.link.next_due_ns
        values: list[Value] = []
        for tick, now_ns in zip(ticks, times_ns, strict=True):
            if not acts:
                # In the soft start the hand would push the device away from its avatar.
                acts = loop.s.coupled or (loop.s.limits.ready and not self._live)
            sample = device.sense(acts)
            if due_ns is not None and due_ns <= now_ns:
                packets = self.down.collect(now_ns)
                due_ns = self.down.link.next_due_ns
            f, _, row = loop.tick(tick - first, now_ns, sample, packets)
            packets = ()
            device.step(f)
            values += row
        self._f, self._acts = f, acts or loop.s.coupled
        return values

    def traces(self) -> UserTraces:
        """Return the traces of the ticks noted, numbered from the first of the loop."""
        notes, tick_s, frames = self.notes, self.settings.master.tick_s, self.notes.frames
        ran = np.array(notes.ticks, dtype=np.int64)
        late_ns = np.array(notes.times_ns, dtype=np.int64) - ran * round(tick_s * 1e9)
        signals = np.array(notes.signals).reshape(-1, len(SIGNALS), self._dof)
        ends, reports, sums, changes = zip(*frames, strict=True) if frames else ((),) * 4
        energies = columns(chain.from_iterable(sums), 1).reshape(-1, len(ENERGIES)).T.copy()
        named: dict[str, Any] = {name: signals[:, k].copy() for k, name in enumerate(SIGNALS)}
        kept = [report.accounts for report in reports]
        own = dict.fromkeys(name for row in kept for name in row)
        return UserTraces(
            name=self.settings.name, tick_s=tick_s, time_s=ran.astype(np.float64) * tick_s,
            tick=ran - self.ticks.first, lateness_s=late_ns.astype(np.float64) * 1e-9,
            compute_s=np.zeros(len(ran)),
            block_time_s=np.minimum(np.array(ends, dtype=np.float64), self.ticks.count) * tick_s,
            energy=dict(zip(ENERGIES, energies, strict=True)),
            state=np.array([report.state for report in reports], dtype=np.int64),
            reason=[report.reason for report in reports],
            accounts={name: np.array([float(row.get(name, 0.0)) for row in kept]) for name in own},
            changes=np.array(changes, dtype=np.int64), looked_ns=late_ns,
            safety_events=self.loop.s.limits.events,
            orientation=np.array([report.orientation for report in reports]),
            missed=int(ran[-1]) - int(ran[0]) + 1 - len(ran) if len(ran) else 0, **named,
        )  # fmt: skip
