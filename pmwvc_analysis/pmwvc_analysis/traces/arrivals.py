# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The packets of a link beside those due: the time spent waiting for late ones, and the ratio left
out by a deadband.

A packet states the time that it stands for. One that comes more than half of that time later than
it is due, counted from the newest one before, is late; lost ones make the next one late. One that
has not come by the end is late as well, unless the link was silent for so long that nobody waits.
"""

from collections.abc import Iterable

import numpy as np

from pmwvc_analysis.traces.thresholds import GONE_S, LATE
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import PacketTraces, SessionTraces


def waited(links: Iterable[PacketTraces], start_s: float, end_s: float) -> float:
    """Return the largest ratio, over the links, of time spent in intervals before late packets."""
    waits_s = [_waited_s(each, start_s, end_s) for each in links]
    return max(waits_s, default=0.0) / (end_s - start_s) if end_s > start_s else 0.0


def _waited_s(packets: PacketTraces, start_s: float, end_s: float) -> float:
    """Return the time before late packets [s]; packets that were not the newest when they came do
    not count.
    """
    order = np.argsort(packets.time_s, kind="stable")
    seq, epoch = packets.seq[order], packets.epoch[order]
    found = np.ones(len(order), dtype=bool)
    for each in np.unique(epoch):
        own = epoch == each
        found[own] = seq[own] > np.maximum.accumulate(np.concatenate([[-1], seq[own]]))[:-1]
    newest = order[found]
    times_s, due_s = packets.time_s[newest], packets.period_s[newest]
    if len(newest) and 0.0 < end_s - times_s[-1] < GONE_S:
        times_s, due_s = np.append(times_s, end_s), np.append(due_s, due_s[-1])
    late = np.diff(times_s) > (1.0 + LATE) * due_s[1:]
    return float(np.diff(np.clip(times_s, start_s, end_s))[late].sum())


def left_out(traces: SessionTraces, scenario: Scenario | None) -> dict[str, float]:
    """Return the ratio of packets that a deadband left out, by link (user1/up) with one. A master
    has one for every frame, a block of its trace; the server for every step with the user there.
    """
    due = {f"/{user.name}/wave_up": len(user.block_time_s) for user in traces.users}
    if (server := traces.server) is not None:
        for name, state in zip(server.users, server.state, strict=True):
            due[f"/server/{name}/wave_down"] = int(np.count_nonzero(state))
    found: dict[str, float] = {}
    for user in scenario.users if scenario else ():
        up, down = f"/{user.name}/wave_up", f"/server/{user.name}/wave_down"
        for way, end, topic in (("up", user.master, up), ("down", user.contact, down)):
            packets = traces.packets.get(topic)
            if end.deadband.is_on and packets is not None and due.get(topic):
                found[f"{user.name}/{way}"] = max(1.0 - len(packets.seq) / due[topic], 0.0)
    return found
