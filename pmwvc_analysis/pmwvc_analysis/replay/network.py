# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The recorded network of a session as links for the simulator.

A packet's delay is the time from its sending to its coming out of the emulator, both on the
monotonic clock of their machine; where sender and emulator are on different machines, from its
going into the emulator. Live, it takes a little longer to the receiver. Where the receiver's trace
shows that the packet was used at an earlier look, or at a later one, the delay is made to fit
(:mod:`pmwvc_analysis.replay.arrivals`).
"""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pmwvc_analysis.recording.format.topics import source_of
from pmwvc_analysis.replay.arrivals import NEVER_NS, Looks, Sent, bounds
from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.network.recorded_link import RecordedFate, RecordedLink
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.conditions import Integers
from pmwvc_core.traces import FateTraces, PacketTraces, SessionTraces

TRANSPORT_NS = 150_000  # from the emulator of a live session to the receiver, usually
TRAVELLING = (FateKind.DELIVERED, FateKind.DUPLICATE)
LONGEST_UPLINK_NS = 100_000_000  # from a sender to the emulator on the same machine

Links = dict[str, Callable[[], RecordedLink]]


def links(
    traces: SessionTraces,
    recorded: Scenario,
    replayed: Scenario,
    *,
    known: Mapping[str, tuple[Sent, Looks]],
) -> tuple[Links, list[str]]:
    """Return what makes the recorded links, by name, and what is not as recorded, as text.

    ``known`` is what was sent and what was used when. A direction whose settings were changed is
    simulated with the new ones, and so is one of which the recording holds no fates.
    """
    found: Links = {}
    notes = []
    transport_ns = TRANSPORT_NS if traces.source == "live" else 0
    for old, new in zip(recorded.users, replayed.users, strict=True):
        for way in ("up", "down"):
            name = f"{old.name}/{way}"
            fates = traces.fates.get(name)
            if getattr(old, f"link_{way}") != getattr(new, f"link_{way}"):
                notes.append(f"{name}: other settings were given, so this link is simulated")
            elif fates is None or not len(fates.seq):
                notes.append(f"{name}: no packet fates were recorded, so this link is simulated")
            else:
                before, after = (
                    user.master.frame_s if way == "up" else scenario.server.period_s
                    for scenario, user in ((recorded, old), (replayed, new))
                )
                sent = traces.packets.get(source_of(name))
                record = record_of(fates, sent, known.get(name), transport_ns)
                found[name] = partial(RecordedLink, record, per_packet=after / before)
                if after != before:
                    notes.append(
                        f"{name}: packets every {after * 1e3:g} ms instead of {before * 1e3:g} ms "
                        "meet the fates recorded at their time"
                    )
    return found, notes


def record_of(
    fates: FateTraces,
    packets: PacketTraces | None,
    known: tuple[Sent, Looks] | None = None,
    transport_ns: int = 0,
) -> Mapping[int, Sequence[RecordedFate]]:
    """Return the fate of every packet and its copies, by packet number.

    Packets of a sender that was started again are numbered on from its last one before.
    """
    rows = np.flatnonzero(fates.fate != FateKind.INVALID)
    rows = rows[np.lexsort((fates.fate[rows], fates.time_in_ns[rows]))]
    number = _numbers(fates, rows)
    since = _sending_times(fates, packets)
    # 0 stands for never, but in virtual time also for a packet without delay at time 0
    at_zero = (fates.time_in_ns == 0) & (fates.time_due_ns == 0)
    came_out = (fates.time_out_ns > 0) | (at_zero & np.isin(fates.fate, TRAVELLING))
    delay_ns = fates.time_out_ns[rows] - since[rows] + transport_ns
    if known:
        delay_ns = delay_ns + _shifts(number, delay_ns, came_out[rows], *known)
    record: dict[int, list[RecordedFate]] = defaultdict(list)
    for packet, delay, came, kind, cause in zip(
        number.tolist(),
        delay_ns.tolist(),
        came_out[rows].tolist(),
        fates.fate[rows].tolist(),
        fates.cause[rows].tolist(),
        strict=True,
    ):
        record[packet].append(RecordedFate(delay if came else None, FateKind(kind), Cause(cause)))
    return record


def _shifts(
    number: Integers, delay_ns: Integers, came: NDArray[np.bool_], sent: Sent, looks: Looks
) -> Integers:
    """Return what makes each delay fit what the receiver used [ns]; of copies the first counts."""
    known = came & (number <= len(sent.time_ns))
    first = np.full(len(sent.time_ns) + 1, NEVER_NS, dtype=np.int64)
    np.minimum.at(first, number[known], delay_ns[known])
    arrival_ns = sent.time_ns[number[known] - 1] + first[number[known]]
    shift = np.zeros_like(delay_ns)
    shift[known] = bounds(sent, looks).moved(number[known], arrival_ns) - arrival_ns
    return shift


def _numbers(fates: FateTraces, rows: Integers) -> Integers:
    """Return packet numbers that go on where an epoch begins again at 1."""
    numbers = fates.seq[rows].copy()
    last = 0
    epochs = fates.epoch[rows]
    _, first = np.unique(epochs, return_index=True)
    for epoch in epochs[np.sort(first)]:
        own = epochs == epoch
        numbers[own] += last
        last = int(numbers[own].max())
    return numbers


def _sending_times(fates: FateTraces, sent: PacketTraces | None) -> Integers:
    """Return when each packet was sent, on the emulator's clock [ns]."""
    if sent is None or not len(sent.seq):
        return fates.time_in_ns
    keys = zip(sent.epoch.tolist(), sent.seq.tolist(), strict=True)
    of_packet = dict(zip(keys, sent.sent_ns.tolist(), strict=True))
    keys = zip(fates.epoch.tolist(), fates.seq.tolist(), strict=True)
    times_ns = map(of_packet.get, keys, fates.time_in_ns.tolist())
    since = np.fromiter(times_ns, dtype=np.int64, count=len(fates.seq))
    uplink_ns = np.median(fates.time_in_ns - since)
    return since if 0 <= uplink_ns <= LONGEST_UPLINK_NS else fates.time_in_ns
