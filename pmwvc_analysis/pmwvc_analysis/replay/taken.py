# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Which packet a receiver used when: what the traces tell about the arrival of packets.

The emulator's times leave open what lies between its socket and the receiver's (about 0.2 ms), so
a packet that came out just before its receiver looked may have been used at that look or at the
next. But the receiver's trace holds the wave it used, and waves are numbers with 16 digits: where
exactly one packet carries that wave, it was the newest at that look. So it had come by then, and
none with a higher number had. A wave of zero tells nothing: it is also used where nothing came.
"""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from pmwvc_core.numeric import Array
from pmwvc_core.simulation.event_schedule import Integers

NEVER_NS = int(np.iinfo(np.int64).max)
NOBODY: list[int] = []


@dataclass(frozen=True)
class Looks:
    """When a receiver looked [ns], and the wave it used then ``(looks, dof)``."""

    time_ns: Integers
    wave: Array


@dataclass(frozen=True)
class Sent:
    """When each packet was sent [ns], and its wave ``(packets, dof)``; packet n in row n - 1."""

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
    """Return what the used waves tell about the arrival of every packet."""
    sent_at = sent.time_ns.tolist()
    count = len(sent_at)
    carriers: dict[bytes, list[int]] = defaultdict(list)
    for number, wave in enumerate(_rows(sent.wave), start=1):
        carriers[wave].append(number)
    last = [-1] * (count + 1)  # look that still used this one
    until = [NEVER_NS] * count
    newest = 0
    tells = list(map(any, looks.wave.tolist()))
    for time_ns, wave, told in zip(looks.time_ns.tolist(), _rows(looks.wave), tells, strict=True):
        possible = carriers[wave] if told and wave in carriers else NOBODY
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
    """Return what the rows of an array are in memory, to be compared bit by bit."""
    together = np.ascontiguousarray(waves).tobytes()
    width = waves.itemsize * waves.shape[-1]
    return [together[start : start + width] for start in range(0, len(together), width)]
