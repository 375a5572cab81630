# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The recorded times of a session, as a simulator takes them.

**Loops.** When every tick of a master and every step of the server took its packets in. Ticks and
steps that a recording lacks (:mod:`pmwvc_analysis.traces.holes`) are taken to have run on time.

**Links.** A packet comes out at the look of its receiver that took it in, as the receiver's trace
says. One that came out of the emulator and was never taken in is lost. Where the receiver's trace
has a hole, a packet has its delay in the emulator; live, it takes a little longer to the receiver.
"""

import math
from collections import defaultdict, deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from pmwvc_analysis.recording.topics import source_of
from pmwvc_analysis.traces.holes import of_server, of_user
from pmwvc_analysis.traces.stages import Stage
from pmwvc_core.network.in_flight import Cause, FateKind, RecordedFate, RecordedLink
from pmwvc_core.numeric import Array, Integers
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import Steps
from pmwvc_core.traces import (
    FateTraces,
    ServerTraces,
    SessionTraces,
    TakenTraces,
    UserTraces,
)

TRANSPORT_NS = 300_000  # to the emulator of a live session and on to the receiver, usually
TRAVELLING = (FateKind.DELIVERED, FateKind.DUPLICATE)
LOW = 0xFFFFFFFF
Links = dict[str, Callable[[], RecordedLink]]


class LoopTimes(NamedTuple):
    """The times of one loop: the tick of the session of each row of its traces, when each row
    took its packets in [ns], and the intervals that were not recorded [ns].
    """

    at: Integers
    looked_ns: Integers
    holes_ns: Sequence[tuple[int, int]]


def tick_numbers(time_s: Array, tick_s: float) -> Integers:
    """Return times as ticks of the session."""
    return np.rint(time_s / tick_s).astype(np.int64)


def times_of(rows: UserTraces | ServerTraces, tick_s: float) -> LoopTimes:
    """Return the times of a master's loop, or the server's."""
    at = tick_numbers(rows.time_s, tick_s)
    gaps = of_user(rows) if isinstance(rows, UserTraces) else of_server(rows)
    gaps_ns = [(round(gap.start_s * 1e9), round(gap.end_s * 1e9)) for gap in gaps]
    return LoopTimes(at, at * round(tick_s * 1e9) + rows.looked_ns, gaps_ns)


def ran_ns(loop: LoopTimes, tick_s: float, ticks: int) -> Integers:
    """Return when each tick of the session ran [ns], negative where it did not ``(ticks,)``."""
    tick_ns = round(tick_s * 1e9)
    result = np.full(ticks, -1, dtype=np.int64)
    for start_ns, end_ns in loop.holes_ns:
        lost = np.arange(max(start_ns // tick_ns, 0), min(-(-end_ns // tick_ns), ticks))
        result[lost] = lost * tick_ns
    within = loop.at < ticks
    result[loop.at[within]] = loop.looked_ns[within]
    return result


def counts_from(
    user: UserTraces, traces: SessionTraces, stages: Sequence[Stage], number: int
) -> int:
    """Return the tick of the session at which the loop of a user (number from 0) counts 0: its
    frames begin at the multiples of the rate drops of all stages.
    """
    rate_drops = [stage.scenario.users[number].master.rate_drop for stage in stages]
    grid = user.grid if traces.live else 0
    begins = int(tick_numbers(user.time_s[:1], user.tick_s)[0])
    return begins - (int(user.tick[0]) + grid) % math.lcm(*rate_drops)


def steps(
    traces: SessionTraces, recorded: Scenario, replayed: Scenario, ticks: int
) -> Steps | None:
    """Return when the server stepped; on its own grid where its period was changed."""
    server, tick_s = traces.server, recorded.tick_s
    tick_ns = round(tick_s * 1e9)
    if server is None:
        return None
    loop, period_s = times_of(server, tick_s), replayed.server.period_s
    if period_s != recorded.server.period_s:
        tick = np.arange(loop.at[0], ticks, round(period_s / tick_s))
        return Steps(tick, tick * tick_ns, np.full(len(tick), period_s))
    columns = loop.at.tolist(), loop.looked_ns.tolist(), server.periods_s.tolist()
    rows = [row for row in zip(*columns, strict=True) if row[0] < ticks]
    missing = np.diff(server.step) - 1
    for row in np.flatnonzero(missing > 0).tolist():
        count, lasts = int(missing[row]), float(server.periods_s[row])
        between = np.linspace(loop.at[row], loop.at[row + 1], count + 2)[1:-1]
        rows += [(int(at), int(at) * tick_ns, lasts) for at in between if at < ticks]
    at, looked_ns, lasts_s = zip(*sorted(rows), strict=True)
    return Steps(np.array(at), np.array(looked_ns), np.array(lasts_s))


def links(
    traces: SessionTraces, recorded: Scenario, replayed: Scenario, loops: Mapping[str, LoopTimes]
) -> tuple[Links, list[str]]:
    """Return what makes the recorded links, by name, and what is not as recorded, as text.

    ``loops`` has the times of the receiving loop of each link. A direction whose settings or rate
    of packets were changed is simulated with the new ones, and so is one of which the recording
    holds nothing.
    """
    found: Links = {}
    notes = []
    for old, new in zip(recorded.users, replayed.users, strict=True):
        for way in ("up", "down"):
            name = f"{old.name}/{way}"
            before, after = (
                user.master.frame_s if way == "up" else scenario.server.period_s
                for scenario, user in ((recorded, old), (replayed, new))
            )
            if getattr(old, f"link_{way}") != getattr(new, f"link_{way}") or before != after:
                notes.append(f"{name}: other settings were given, so this link is simulated")
                continue
            if name not in traces.taken:
                notes.append(f"{name}: its receiver was not recorded, so this link is simulated")
                continue
            found[name] = partial(RecordedLink, _record(traces, name, loops[name]))
    return found, notes


def _record(
    traces: SessionTraces, name: str, loop: LoopTimes
) -> Mapping[int, Sequence[RecordedFate]]:
    """Return the fate of every packet of a link and its copies, by packet number, with the
    instants at which they were taken in. Packets of a sender that was started again are numbered
    on from its last one before.
    """
    fates = traces.fates.get(name)
    zero_ns = traces.metadata.get("fate_zero_ns", {}).get(name, 0)
    instants = _instants(traces.taken[name], loop)
    own = _own_sender(traces, name)
    record: dict[int, list[RecordedFate]] = defaultdict(list)
    if fates is not None:
        # in the order of sending, copies behind their packet
        rows = np.flatnonzero(fates.fate != FateKind.INVALID)
        rows = rows[np.lexsort((fates.fate[rows], fates.time_in_ns[rows]))]
        # 0 stands for never, but in virtual time also for a packet without delay at time 0
        at_zero = (fates.time_in_ns == 0) & (fates.time_due_ns == 0)
        came_out = (fates.time_out_ns > 0) | (at_zero & np.isin(fates.fate, TRAVELLING))
        delays = fates.time_out_ns - fates.time_in_ns + (TRANSPORT_NS if traces.live else 0)
        for row, number in zip(rows.tolist(), _numbers(fates, rows).tolist(), strict=True):
            kind, cause = FateKind(fates.fate[row]), Cause(fates.cause[row])
            delay_ns, at_ns = int(delays[row]) if came_out[row] else None, None
            if delay_ns is not None and cause is not Cause.CORRUPTION:
                key = int(fates.epoch[row]) & LOW, int(fates.seq[row])
                out_ns = int(fates.time_out_ns[row]) - zero_ns
                if queue := instants.get(key):
                    at_ns = queue.popleft() if key[0] == own else None
                elif not any(start <= out_ns < end for start, end in loop.holes_ns):
                    delay_ns = None
            record[number].append(RecordedFate(delay_ns, kind, cause, at_ns))
    for (epoch, seq), queue in instants.items():
        for at_ns in queue if epoch == own else ():  # the emulator's record lacks them
            kind = FateKind.DUPLICATE if record[seq] else FateKind.DELIVERED
            record[seq].append(RecordedFate(0, kind, at_ns=at_ns))
    return record


def _instants(taken: TakenTraces, loop: LoopTimes) -> dict[tuple[int, int], deque[int]]:
    """Return when each packet was taken in, and its copies [ns], by its sender's epoch (lowest
    bits) and number. Those of one look come out one nanosecond after the other: in their order.
    """
    found: dict[tuple[int, int], deque[int]] = defaultdict(deque)
    behind = np.searchsorted(taken.row, taken.row, side="right") - 1 - np.arange(len(taken.row))
    at_ns = loop.looked_ns[taken.row] - behind
    for *packet, time_ns in np.stack([taken.epoch, taken.seq, at_ns], axis=-1).tolist():
        found[tuple(packet)].append(time_ns)
    return found


def _own_sender(traces: SessionTraces, name: str) -> int:
    """Return the first start of a link's sender: the lowest bits of its epoch."""
    seen = traces.packets.get(source_of(name)), traces.fates.get(name), traces.taken.get(name)
    return next((int(e.epoch[0]) & LOW for e in seen if e is not None and len(e.epoch)), 0)


def _numbers(fates: FateTraces, rows: Integers) -> Integers:
    """Return packet numbers that go on where an epoch begins again at 1."""
    numbers, epochs, last = fates.seq[rows].copy(), fates.epoch[rows], 0
    for epoch in dict.fromkeys(epochs.tolist()):
        own = epochs == epoch
        numbers[own] += last
        last = int(numbers[own].max())
    return numbers
