# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's loop: one step of the environment per period, 2 ms after the frames of the masters.

What a step computes is in :class:`pmwvc_core.server.service.Service`; this file decides *when*,
on the grid of the monotonic clock that all processes of a machine share: packets sent at a frame
start are used 2 ms later, the answers taken 2 ms after that. Steps begin with the first user. No
ROS here: the wires to the outside are an argument.
"""

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

from pmwvc_core.plant.task import ShownTarget
from pmwvc_core.runtime.health import Health
from pmwvc_core.runtime.pacing import Pacer, RealTimeReport, Tick, request_real_time
from pmwvc_core.server.service import Presence, Service
from pmwvc_core.transport.packet import FLAG_DIRECT, WavePacket

PHASE_NS = 2_000_000
PRIORITY = 20


class Wires(Protocol):
    """What joins the loop to the network and to those who watch."""

    def take(self, user: int) -> WavePacket | None:
        """Return a user's next packet that has arrived, or None; never wait."""

    def send(self, user: int, packet: WavePacket) -> None:
        """Send a packet to a user."""

    def publish_trace(self, loop: "ServerLoop", tick: Tick, compute_s: float) -> None:
        """Publish the step just made."""


class ServerLoop:
    """The environment for all users, in time.

    Parameters
    ----------
    service
        Receivers, membership, environment and senders.
    target
        Where the object is to be brought.
    wires
        The outside.
    period_s
        Time step of the environment [s].
    clock
        The monotonic clock [ns].

    Attributes
    ----------
    steps
        Steps made so far.
    changes
        Users whose presence changed, with the new one; another thread takes them out.
    """

    def __init__(
        self,
        service: Service,
        target: ShownTarget,
        *,
        wires: Wires,
        period_s: float,
        clock: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self.service = service
        self.target = target
        self.wires = wires
        self.period_s = period_s
        self.steps = 0
        self.missed = 0
        self.foreign = 0  # packets of another kind of controller
        self.health = Health()
        self.report: RealTimeReport | None = None
        self.changes: deque[tuple[int, Presence]] = deque(maxlen=1000)
        self._clock = clock
        self._users = range(len(service.inboxes))
        self._before = list(service.presence)

    def run(self, stop: threading.Event) -> None:
        """Step in this thread until ``stop`` is set."""
        self.report = request_real_time(PRIORITY)
        for tick in Pacer(round(self.period_s * 1e9), phase_ns=PHASE_NS).ticks(stop):
            self.tick(tick)

    def tick(self, tick: Tick) -> None:
        """Take what has arrived, step, answer."""
        self.missed += tick.skipped
        for user in self._users:
            while (packet := self.wires.take(user)) is not None:
                if (packet.flags ^ self.service.server.flags) & FLAG_DIRECT:
                    self.foreign += 1
                else:
                    self.service.deliver(user, packet, self._clock())
        if not self.steps and all(p is Presence.ABSENT for p in self.service.presence):
            return
        answers = self.service.step(self._clock())
        for user, answer in enumerate(answers):
            if answer is not None:
                self.wires.send(user, answer)
        self.steps += 1
        self.target.step(together=self.service.together())
        self._notice()
        compute_ns = self._clock() - tick.woke_ns
        self.health.add(tick.lateness_ns, compute_ns)
        self.wires.publish_trace(self, tick, compute_ns * 1e-9)

    def _notice(self) -> None:
        """Note who came, fell silent or left."""
        for user, presence in enumerate(self.service.presence):
            if presence is not self._before[user]:
                self._before[user] = presence
                self.changes.append((user, presence))
