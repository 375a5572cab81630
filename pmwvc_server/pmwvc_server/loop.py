# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The server's loop in real time: one step of the environment per period.

:class:`pmwvc_core.ends.server_end.ServerEnd` has the protocol; this file gives it packets and
times, :data:`pmwvc_core.frame.LIVE` after the frame starts on the grid of the monotonic
clock that all processes of a machine share. Steps begin with the first user. No ROS here: links
and observers are arguments.
"""

import threading
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.frame import LIVE, ServerRow
from pmwvc_core.law.user_tick import next_on_grid
from pmwvc_core.params import ServerParams
from pmwvc_core.runtime.pacing import Paced, Pacer, Tick
from pmwvc_core.transport.packet import PacketLink, WavePacket

PRIORITY = 20
PHASE_NS = round(LIVE.server_s * 1e9)


class MadeStep(NamedTuple):
    """A step just made, with the packets of each user taken in at an instant."""

    row: ServerRow
    tick: Tick
    looked_ns: int
    packets: Sequence[Sequence[WavePacket]]
    compute_s: float


class ServerLoop(Paced):
    """The environment for all users, in time; ``links``: the packets of each.

    ``clock`` is the monotonic clock [ns].
    """

    def __init__(
        self, protocol: ServerEnd, *, links: Sequence[PacketLink],
        publish_trace: Callable[["ServerLoop", MadeStep], None],
        clock: Callable[[], int] = time.monotonic_ns,
    ) -> None:  # fmt: skip
        self.protocol, self._links, self._clock = protocol, links, clock
        super().__init__()
        self._publish_trace, self._due_ns = publish_trace, 0  # due: the present step

    def run(self, stop: threading.Event) -> None:
        """Step in this thread until ``stop`` is set."""
        self.request(PRIORITY)
        pacer = Pacer(self._period_ns, phase_ns=PHASE_NS)
        for tick in pacer.ticks(stop):
            self.tick(tick)
            if pacer.period_ns != self._period_ns:
                pacer.retime(self._period_ns)

    @property
    def _period_ns(self) -> int:
        return round(self.protocol.params.period_s * 1e9)

    def configure(self, params: ServerParams) -> None:
        """Take other parameters over in a step; with another period it ends on the new grid."""
        ends_ns = next_on_grid(self._due_ns, round(params.period_s * 1e9), PHASE_NS)
        self.protocol.configure(params, first_s=(ends_ns - self._due_ns) * 1e-9)

    def tick(self, tick: Tick) -> None:
        """Take in what has arrived, step, answer."""
        self.missed, self._due_ns = self.missed + tick.skipped, tick.due_ns
        packets = [link.take() for link in self._links]
        looked_ns = self._clock()
        missed_s = tick.skipped * self._period_ns * 1e-9
        answers, row = self.protocol.tick(looked_ns, packets, missed_s)
        if row is None:
            return
        for link, answer in zip(self._links, answers, strict=True):
            if answer is not None:
                link.send(answer)
        compute_ns = self._clock() - tick.woke_ns
        self.took_ns.extend((tick.lateness_ns, compute_ns))
        self._publish_trace(self, MadeStep(row, tick, looked_ns, packets, compute_ns * 1e-9))
