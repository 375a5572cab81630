# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The receiver of one direction: packets are judged and counted, the newest is kept; and what one
end of a link has received, by the names of the Reception message. What is accepted is for the laws
of the channel (:mod:`pmwvc_core.law.channel`).

It follows one sender (one epoch) at a time. A packet counts if it is new::

    of the sender followed      its number is above the newest one, by less than ``AHEAD``
    or it proves it             it echoes a packet that this end sent after it took the newest one

Proof is asked of a sender whose numbers jump, of one that has left, and of another one, which
moreover takes over only when the one followed is silent or has left. The first packet of all is
taken as it is. Time is an argument (integer nanoseconds of this end's monotonic clock).
"""

import math

import numpy as np

from pmwvc_core.numeric import AXES, Value, finite, squared
from pmwvc_core.quaternions import Orientation, unit
from pmwvc_core.transport.packet import FLAG_CHALLENGE, FLAG_LEAVING, Receipt, WavePacket, ahead
from pmwvc_core.transport.path import LONGEST_ROUND_TRIP_NS, Path, PathEstimate

LONGEST_PERIOD_S = 10.0  # of a packet on the strict channel
AHEAD = 1 << 16  # numbers: a jump farther than that has to be proven
WINDOW = 256  # packet numbers below the newest of which we know whether they came
KNOWN = (1 << WINDOW) - 1
ACCEPTED = Receipt.ACCEPTED  # at hand: a member is looked up in Python
NEW_EPOCH, STRANGER = Receipt.NEW_EPOCH, Receipt.STRANGER
_TAKEN = (Receipt.ACCEPTED, Receipt.NEW_EPOCH, Receipt.DUPLICATE, Receipt.REORDERED)
REFUSED = {each.name.lower(): each for each in Receipt if each not in _TAKEN}  # by message field
ROUND_TRIP = "round trip [ms]"  # of diagnostics
PASSAGE = (  # fields of the Reception message
    *("delay_least", "delay_mean", "delay_max", "jitter"),  # [s] of packets that come in
    "delay_open",  # [s] bound of these; 0 where both ends read one clock
    *("offset", "drift", "drift_open"),  # sender's clock less the receiver's [s], change, bound
    "round_trip",  # [s] the least
)


class Receiver:
    """The receiving end of one direction: ``dof`` values per packet, which stands for
    ``period_s``, or for ``any_period`` up to ``LONGEST_PERIOD_S``; silence begins after
    ``timeout_s`` or three periods, whichever is longer; ``max_wave`` is the longest wave that is
    legal [sqrt(W)].
    """

    def __init__(
        self, dof: int, *, period_s: float, timeout_s: float, max_wave: Value = math.inf,
        any_period: bool = False,
    ) -> None:  # fmt: skip
        self.dof, self.max_wave = dof, max_wave
        self._period_s, self._any_period = period_s, any_period
        self.counts = dict.fromkeys(Receipt, 0)
        self.lost = 0  # numbers skipped and not come since
        self.newest: WavePacket | None = None  # accepted; None before the first
        self.round_trip_s: float | None = None
        self.orientation: Orientation = ()  # of the newest, x y z w
        self.silence_ns = round(max(timeout_s, 3.0 * period_s) * 1e9)
        self.accepted_ns = 0  # when the newest was taken,
        self.came_ns = 0  # and when it reached this end, which may be before
        self.path = Path()  # delay and jitter of the packets, both ways
        self._left = False  # the sender followed
        self._first = 0  # number at which this baseline began
        self._seen = 0  # bit i: number newest.seq - i has come
        self._stranger: WavePacket | None = None  # the newest of a sender that is not followed,
        self._stranger_ns = 0  # and when it came

    def push(self, packet: WavePacket, now_ns: int) -> Receipt:
        """Judge a packet that has come in; whatever it is, the answer is a verdict."""
        verdict = self._unfit(packet) or self._placed(packet, now_ns)
        self.counts[verdict] += 1
        if verdict is ACCEPTED or verdict is NEW_EPOCH:
            self._accept(packet, now_ns, fresh=verdict is not ACCEPTED)
        elif verdict is STRANGER or verdict is Receipt.STALE:
            self._stranger, self._stranger_ns = packet, packet.came_ns or now_ns
        return verdict

    @property
    def epoch(self) -> int:
        """The sender followed; 0 before the first packet."""
        return 0 if self.newest is None else self.newest.epoch

    def silent(self, now_ns: int) -> bool:
        """Tell whether nothing was accepted for too long (also before the first packet)."""
        return self.newest is None or now_ns - self.accepted_ns > self.silence_ns

    def echo(self, now_ns: int) -> tuple[int, int, int]:
        """Return number, sender's clock and holding time [ns] of the newest packet, zeros before
        it. Where nobody is followed: of the sender that came last, to which to prove oneself.
        """
        newest, came_ns = self.newest, self.came_ns
        if self._stranger is not None and self._vacant(now_ns):
            newest, came_ns = self._stranger, self._stranger_ns
        return (0, 0, 0) if newest is None else (newest.seq, newest.sent_ns, now_ns - came_ns)

    def challenges(self, now_ns: int) -> bool:
        """Tell whether a sender comes that has to prove itself."""
        waits = self._stranger is not None and now_ns - self._stranger_ns <= self.silence_ns
        return waits and self._vacant(now_ns)

    def _vacant(self, now_ns: int) -> bool:
        """Tell whether another sender may be followed."""
        return self.silent(now_ns) or self._left

    def _unfit(self, packet: WavePacket) -> Receipt | None:
        """Return what is wrong with a packet by itself; None where nothing is."""
        if packet.refusal is not None or not 1 <= packet.seq < 1 << 32:  # uint32 in the message
            return packet.refusal or Receipt.MALFORMED
        signals, dof = (packet.wave, packet.integral, packet.position), self.dof
        others = packet.energy, packet.period, *packet.extra, *packet.orientation
        if not all(map(finite, (*signals, *others))):
            return Receipt.NOT_FINITE
        for value in signals:  # the zero of a start has any number of axes
            if value.shape != (dof,) if isinstance(value, np.ndarray) else dof > 1 and value:
                return Receipt.WRONG_LENGTH
        if dof == AXES and not unit(packet.orientation, self.orientation):
            return Receipt.MALFORMED
        if not (
            0.0 < packet.period <= LONGEST_PERIOD_S
            if self._any_period
            else math.isclose(packet.period, self._period_s, rel_tol=1e-6)
        ):
            return Receipt.WRONG_PERIOD
        return Receipt.TOO_LARGE if squared(packet.wave) > self.max_wave**2 else None

    def _placed(self, packet: WavePacket, now_ns: int) -> Receipt:
        """Judge a fit packet by those before it."""
        newest = self.newest
        if packet.flags & FLAG_CHALLENGE:
            return STRANGER
        if newest is None:
            return NEW_EPOCH
        proven = self.accepted_ns < packet.echo_sent_ns <= now_ns
        if packet.epoch != newest.epoch:
            return NEW_EPOCH if proven and self._vacant(now_ns) else STRANGER
        behind = -ahead(newest, packet)
        if proven or (-AHEAD < behind < 0 and not self._left):
            return ACCEPTED
        if behind >= 0 and self._seen >> behind & 1:
            return Receipt.DUPLICATE
        if 0 <= behind < WINDOW:
            self._seen |= 1 << behind
            self.lost -= packet.seq > self._first  # numbers before the first were never missing
        return Receipt.STALE if behind < 0 or self._left else Receipt.REORDERED

    def _accept(self, packet: WavePacket, now_ns: int, *, fresh: bool) -> None:
        before, self._stranger = self.newest, None
        skipped = -1 if fresh or before is None else ahead(before, packet) - 1
        if 0 <= skipped < AHEAD:
            self.lost += skipped
            self._seen = (self._seen << min(skipped + 1, WINDOW) | 1) & KNOWN
        else:  # its numbers begin
            self._seen, self._first = 1, packet.seq
            self.path.restart()
        self.newest, self._left = packet, bool(packet.flags & FLAG_LEAVING)
        self.orientation = unit(packet.orientation, self.orientation)
        self.accepted_ns = now_ns
        self.came_ns = came_ns = packet.came_ns or now_ns
        self.path.add(packet, came_ns)
        if packet.echo_seq > 0:
            round_trip_ns = came_ns - packet.echo_sent_ns - packet.echo_hold_ns
            if 0 <= round_trip_ns <= LONGEST_ROUND_TRIP_NS:
                self.round_trip_s = round_trip_ns * 1e-9


def counts(inbox: Receiver, *, other_controller: int = 0) -> dict[str, int]:
    """Return the counts of a receiver by the names of the Reception message."""
    by_verdict = inbox.counts
    beginnings = by_verdict[Receipt.NEW_EPOCH]
    return {
        "accepted": by_verdict[Receipt.ACCEPTED] + beginnings,
        "beginnings": beginnings,
        "lost": inbox.lost,
        "duplicate": by_verdict[Receipt.DUPLICATE],
        "reordered": by_verdict[Receipt.REORDERED],
        **{name: by_verdict[verdict] for name, verdict in REFUSED.items()},
        "other_controller": other_controller,
    }


def passage(path: PathEstimate | None) -> dict[str, float]:
    """Return an estimate by the names of the Reception message; NaN where not known."""
    if path is None:
        return dict.fromkeys(PASSAGE, math.nan)
    into = path.into
    delays = (into.least_s, into.mean_s, into.most_s, into.jitter_s, path.open_s)
    clocks = (path.offset_s, path.drift_ppm * 1e-6, path.drift_open_ppm * 1e-6)
    return dict(zip(PASSAGE, (*delays, *clocks, path.round_trip_s), strict=True))


def diagnostics(inbox: Receiver, *, out: str, into: str) -> dict[str, object]:
    """Return what a receiver has seen for people, by name, in directions of these names."""
    trip, path = inbox.round_trip_s, inbox.path.estimate()
    found: dict[str, object] = {
        "packets lost": inbox.lost,
        ROUND_TRIP: "unknown" if trip is None else f"{trip * 1e3:.1f}",
    }
    if path is None:
        found |= {f"delay {out}": "unknown", f"delay {into}": "unknown"}
    else:
        for name, way in ((out, path.out), (into, path.into)):
            least = f"(least {way.least_s * 1e3:.2f})"
            found[f"delay {name} [ms]"] = f"{way.mean_s * 1e3:.2f} {least}"
            found[f"jitter {name} [ms]"] = f"{way.jitter_s * 1e3:.3f}"
        found["clocks"] = (
            "one clock: delays are exact"
            if path.one_clock
            else f"{path.offset_s:+.6f} s apart, drift {path.drift_ppm:+.1f} +- "
            f"{path.drift_open_ppm:.1f} ppm; round trip known, its halves within "
            f"+-{path.open_s * 1e3:.2f} ms"
        )
    return found | {f"packets {verdict.value}": inbox.counts[verdict] for verdict in Receipt}
