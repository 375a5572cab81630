# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The receiver of one direction: packets are judged and counted, the newest is kept.

This is the receiver of the plain channel (the dissertation's) and of the zeroing one. It guards
against broken and stray packets, not against the energy that holding a wave creates; what is
accepted is given out by its ``playout`` (:class:`.rates.Latest`). That of the strict channel is
built on it (:mod:`.strict_receiver`).
It follows one sender at a time: another epoch takes over only when the sender followed is silent
or has left, and only as one that sends as fast as a sender does (:mod:`.senders`).
Time is an argument (integer nanoseconds of this end's monotonic clock).
"""

import math

from pmwvc_core.numeric import Flag, Value
from pmwvc_core.state import Stateful
from pmwvc_core.transport.fitness import unfit
from pmwvc_core.transport.packet import FLAG_LEAVING, WavePacket
from pmwvc_core.transport.path import Path
from pmwvc_core.transport.senders import INSIST, Run, Senders
from pmwvc_core.transport.verdict import Verdict
from pmwvc_core.wave.playout import Playout
from pmwvc_core.wave.rates import Latest

WINDOW = 256  # packet numbers below the newest of which we know whether they came
KNOWN = (1 << WINDOW) - 1
RETIRED = 16  # former epochs remembered, so that a straggler cannot bring one back
LONGEST_ROUND_TRIP_NS = 600 * 10**9
ACCEPTED = Verdict.ACCEPTED  # at hand: a member is looked up in Python
OUT_OF_PLACE = (Verdict.REORDERED, Verdict.STALE, Verdict.STRANGER)  # right but for their order


class Receiver(Stateful):
    """The receiving end of one direction.

    One bad packet cannot lock the receiver: a wild number makes the true packets look old, but
    once nothing was accepted for the time of silence, 8 of them in a row are believed. The very
    first packet is accepted on its own; its sender gives way to a credible one until it is
    credible itself.

    Parameters
    ----------
    dof
        Values per packet; in a batch the length of the last axis.
    period_s
        Duration that every packet must stand for [s].
    timeout_s
        Silence begins after this or three periods, whichever is longer [s].
    max_wave
        Longest wave that a legal device can emit [sqrt(W)]; no limit by default. In a batch one of
        each run.
    once
        Whether a wave counts for one step (the zeroing channel).

    Attributes
    ----------
    playout
        What has arrived and is given out.
    """

    BLOCKS = "path playout"
    MEMORY = (
        "counts lost newest round_trip_s accepted_ns came_ns _seen _first _retired others _own"
    )
    plays_on = False  # in a silence; and whoever uses the playout steps it
    playout: Latest | Playout

    def __init__(
        self,
        dof: int,
        *,
        period_s: float,
        timeout_s: float,
        max_wave: Value = math.inf,
        once: bool = False,
    ) -> None:
        self.dof = dof
        self.period_s = period_s
        self.max_wave = max_wave
        self.counts = dict.fromkeys(Verdict, 0)
        self.lost = 0  # numbers skipped and not come since
        self.newest: WavePacket | None = None  # accepted; None before the first
        self.round_trip_s: float | None = None
        self._silence_ns = round(max(timeout_s, 3.0 * period_s) * 1e9)
        self.accepted_ns = 0  # when the newest was taken,
        self.came_ns = 0  # and when it reached this end, which may be before
        self.path = Path()  # delay and jitter of the packets, both ways
        self.playout = Latest(once=once)
        self._first = 0  # number at which this baseline began
        self._seen = 0  # bit i: number newest.seq - i has come
        self._retired: list[int] = []
        self.others = Senders(self._silence_ns)
        self._own: Run | None = None  # of the sender followed, until it is credible

    def push(self, packet: WavePacket, now_ns: int) -> Verdict:
        """Judge a packet that has come in; whatever it is, the answer is a verdict."""
        ordinary = type(packet) is WavePacket and self._ordinary(packet)
        wrong = None if ordinary else unfit(packet, self.dof, self.max_wave, lasts=self._lasts)
        verdict = wrong or self._placed(packet)
        if verdict is not ACCEPTED:
            if verdict in OUT_OF_PLACE and self._believed(packet, verdict, now_ns):
                verdict = Verdict.NEW_EPOCH
            if verdict is not Verdict.NEW_EPOCH:
                self.counts[verdict] += 1
                if verdict in OUT_OF_PLACE and packet.epoch != self.epoch:
                    self.others.refuse(packet.epoch)
                return verdict
        self.counts[verdict] += 1
        self._accept(packet, now_ns, fresh=verdict is not ACCEPTED)
        return verdict

    def spared(self, h: float) -> Value:
        """Return energy that the other end lacks and this one has, over ``h`` seconds [J]."""
        return 0.0 if self.newest is None else self.playout.spared(h, wanted=self.newest.short)

    def waits(self, now_ns: int) -> tuple[Flag, bool]:
        """Tell whether this end or the other one has nothing at hand, and whether the other end
        has had nothing of this one for too long: never here.
        """
        return False, False

    @property
    def timeout_s(self) -> float:
        """Time without a packet after which this end is silent [s]."""
        return self._silence_ns * 1e-9

    def position(self) -> Value:
        """Return the position that came with the newest wave [m]; zero before the first packet."""
        return 0.0 if self.newest is None else self.newest.position

    @property
    def epoch(self) -> int:
        """The sender followed; 0 before the first packet."""
        return 0 if self.newest is None else self.newest.epoch

    def connected(self) -> bool:
        """Tell whether any packet was ever accepted."""
        return self.newest is not None

    def silent(self, now_ns: int) -> bool:
        """Tell whether nothing was accepted for too long (also before the first packet)."""
        return self.newest is None or now_ns - self.accepted_ns > self._silence_ns

    def silence_s(self, now_ns: int) -> float:
        """Return the time since the last accepted packet [s]; infinite before the first."""
        return math.inf if self.newest is None else (now_ns - self.accepted_ns) * 1e-9

    def echo(self, now_ns: int) -> tuple[int, int, int]:
        """Return number, sender's clock and holding time [ns] of the newest packet, for the next
        one that goes back; zeros before the first.
        """
        if self.newest is None:
            return 0, 0, 0
        return self.newest.seq, self.newest.sent_ns, now_ns - self.came_ns

    def _ordinary(self, packet: WavePacket) -> bool:
        """Tell at a glance that nothing is wrong with a packet of one axis, as nearly always."""
        p = packet
        return (
            self.dof == 1
            and p.refusal is None
            and type(p.wave) is type(p.integral) is type(p.energy) is type(p.position) is float
            and type(p.epoch) is type(p.seq) is type(p.sent_ns) is type(p.flags) is int
            and type(p.came_ns) is int
            and type(p.echo_seq) is type(p.echo_sent_ns) is type(p.echo_hold_ns) is int
            and 1 <= p.seq < 1 << 32
            and (p.period == self.period_s or self._lasts(p.period))
            and bool(-self.max_wave <= p.wave <= self.max_wave)
            and math.isfinite(p.wave + p.integral + p.energy + p.position)
        )

    def _lasts(self, period_s: float) -> bool:
        """Tell whether a packet may stand for so long."""
        return math.isclose(period_s, self.period_s, rel_tol=1e-6)

    def _placed(self, packet: WavePacket) -> Verdict:
        """Judge a fit packet by those before it."""
        newest = self.newest
        if newest is None:
            return Verdict.NEW_EPOCH
        if packet.epoch != newest.epoch:
            return Verdict.STALE if packet.epoch in self._retired else Verdict.STRANGER
        if packet.seq > newest.seq:
            return Verdict.STALE if packet.sent_ns < newest.sent_ns else ACCEPTED
        behind = newest.seq - packet.seq
        if self._seen >> behind & 1:
            return Verdict.DUPLICATE
        if behind < WINDOW:
            self._seen |= 1 << behind
            self.lost -= packet.seq > self._first  # numbers before the first were never missing
        return Verdict.REORDERED

    def _believed(self, packet: WavePacket, verdict: Verdict, now_ns: int) -> bool:
        """Tell whether a packet that is out of place becomes the new baseline."""
        run = self.others.add(packet.epoch, packet.seq, now_ns, packet.period)
        if verdict is not Verdict.STRANGER:
            return run.count >= INSIST and self.silent(now_ns)
        if self.newest is not None and self.newest.flags & FLAG_LEAVING:
            return True
        return run.credible and (self._own is not None or self.silent(now_ns))

    def _accept(self, packet: WavePacket, now_ns: int, *, fresh: bool) -> None:
        before = self.newest
        if fresh:
            if before is not None and before.epoch != packet.epoch:
                self._retired = [*self._retired[-RETIRED + 1 :], before.epoch]
            self._seen = 1
            self._first = packet.seq
            self._own = self.others.followed(packet.epoch, packet.seq, now_ns, packet.period)
        elif before is not None:
            ahead = packet.seq - before.seq
            self.lost += ahead - 1
            self._seen = (self._seen << (ahead if ahead < WINDOW else WINDOW) | 1) & KNOWN
            if self._own is not None:
                self._own.add(packet.seq, now_ns, packet.period)
        if self._own is not None and self._own.credible:
            self._own = None
        if self.others.runs:
            self.others.forget(packet.epoch if self._own else None)
        self.newest = packet
        self.accepted_ns = now_ns
        self.came_ns = came_ns = packet.came_ns or now_ns
        if fresh:
            self.path.restart()
        self.path.add(packet, came_ns)
        if isinstance(self.playout, Latest):
            self.playout.add(packet)
        if packet.echo_seq > 0:
            round_trip_ns = came_ns - packet.echo_sent_ns - packet.echo_hold_ns
            if 0 <= round_trip_ns <= LONGEST_ROUND_TRIP_NS:
                self.round_trip_s = round_trip_ns * 1e-9
