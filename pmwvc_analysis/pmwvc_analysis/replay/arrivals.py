# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The arrival of packets at their receivers, as far as the traces show it.

The emulator's times leave open the time between its socket and the receiver's (about 0.2 ms), so
a packet that came out just before its receiver looked may have been used at that look or at the
next. But the receiver's trace holds the wave it used, and waves are numbers with 16 digits: where
exactly one packet carries that wave, it was the newest at that look. So it had come by then, and
none with a higher number had. A wave of zero shows nothing: it is also used where nothing came.
"""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pmwvc_analysis.recording.format.topics import source_of
from pmwvc_analysis.replay.loop_times import LoopTimes
from pmwvc_core.controllers import has_waves
from pmwvc_core.numeric import Array
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import Integers, Steps
from pmwvc_core.traces import PacketTraces, SessionTraces, UserTraces

NEVER_NS = int(np.iinfo(np.int64).max)
MOST_MISSING = 3  # packets that may be missing at the end of a recording


@dataclass(frozen=True)
class Looks:
    """Times at which a receiver looked [ns], and the wave used then ``(looks, dof)``."""

    time_ns: Integers
    wave: Array


@dataclass(frozen=True)
class Sent:
    """Sending time [ns] and wave ``(packets, dof)`` of each packet; packet n in row n - 1."""

    time_ns: Integers
    wave: Array


@dataclass(frozen=True)
class Bounds:
    """Packet n arrived after ``after_ns[n - 1]`` and not later than ``until_ns[n - 1]``."""

    after_ns: Integers
    until_ns: Integers

    def moved(self, number: Integers, arrival_ns: Integers) -> Integers:
        """Return the times nearest to arrivals at which these packets may have come [ns]."""
        after, until = self.after_ns[number - 1], self.until_ns[number - 1]
        return np.maximum(np.minimum(arrival_ns, until), after + 1)


def bounds(sent: Sent, looks: Looks) -> Bounds:
    """Return what the used waves show of the arrival of every packet."""
    sent_at = sent.time_ns.tolist()
    count = len(sent_at)
    carriers: dict[bytes, list[int]] = defaultdict(list)
    for number, wave in enumerate(_rows(sent.wave), start=1):
        carriers[wave].append(number)
    last = [-1] * (count + 1)  # look that still used this one
    until = [NEVER_NS] * count
    newest = 0
    nonzero = np.any(looks.wave, axis=-1).tolist()
    for time_ns, wave, known in zip(
        looks.time_ns.tolist(), _rows(looks.wave), nonzero, strict=True
    ):
        possible = carriers.get(wave, []) if known else []
        if len(possible) > 1:
            possible = [n for n in possible if n >= newest and sent_at[n - 1] <= time_ns]
        if len(possible) != 1:
            continue
        number = possible[0]
        if number >= newest and sent_at[number - 1] <= time_ns:
            if number > newest:
                newest = number
                until[newest - 1] = time_ns
            last[newest] = time_ns
    after = np.maximum.accumulate(np.array(last, dtype=np.int64))[:count]
    return Bounds(after, np.array(until, dtype=np.int64))


def _rows(waves: Array) -> list[bytes]:
    """Return the rows of an array as they are in memory, to be compared bit by bit."""
    together = np.ascontiguousarray(waves).tobytes()
    width = waves.itemsize * waves.shape[-1]
    return [together[start : start + width] for start in range(0, len(together), width)]


def tick_numbers(time_s: Array, tick_s: float) -> Integers:
    """Return times as ticks of the session."""
    return np.rint(time_s / tick_s).astype(np.int64)


def sent_and_used(
    traces: SessionTraces, recorded: Scenario, loops: Mapping[str, LoopTimes], steps: Steps | None
) -> dict[str, tuple[Sent, Looks]]:
    """Return what is known of the links of a session, by name.

    A link is left out where its sender was started again or its packets were not recorded.
    """
    server = traces.server
    if server is None or steps is None or not has_waves(recorded.controller):
        return {}
    found: dict[str, tuple[Sent, Looks]] = {}
    count = len(steps.tick)
    for user in traces.users:
        if user.name not in server.users or user.name not in loops:
            continue
        port, loop = server.users.index(user.name), loops[user.name]
        up, down = f"{user.name}/up", f"{user.name}/down"
        _, sends_ns = loop.frame_events(0)
        if (sent := _sent(traces.packets.get(source_of(up)), sends_ns)) is not None:
            found[up] = sent, Looks(steps.ran_ns, server.u_s[port][:count])
        answers_ns = steps.ran_ns[server.state[port][:count] > 0]
        if (sent := _sent(traces.packets.get(source_of(down)), answers_ns)) is not None:
            found[down] = sent, _used_by_master(user, loop)
    return found


def _sent(packets: PacketTraces | None, times_ns: Integers) -> Sent | None:
    """Return the packets of a sender with the times it sent at, where all are there."""
    if packets is None or not len(packets.seq) or len(np.unique(packets.epoch)) > 1:
        return None
    count = min(len(packets.seq), len(times_ns))
    whole = np.array_equal(packets.seq[:count], np.arange(1, count + 1))
    if not whole or len(times_ns) - len(packets.seq) > MOST_MISSING:
        return None
    return Sent(times_ns[:count], packets.wave[:count])


def _used_by_master(user: UserTraces, loop: LoopTimes) -> Looks:
    """Return the waves a master used: what its hold has reached before the next answer."""
    tick, time_ns = loop.frame_events(loop.answer)
    rows = np.searchsorted(tick_numbers(user.time_s, user.tick_s), tick[1:]) - 1
    return Looks(time_ns[:-1], user.v_m[rows])
