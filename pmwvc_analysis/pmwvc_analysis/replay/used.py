# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""From the traces of a session: what was sent on each link, and what its receiver used when."""

from collections.abc import Mapping

import numpy as np

from pmwvc_analysis.replay.taken import Looks, Sent
from pmwvc_core.controllers import has_waves
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.simulation.event_schedule import EventKind, Integers, Loop, Steps, frame_events
from pmwvc_core.traces import PacketTraces, SessionTraces, UserTraces

FAR_OFF = 3  # packets that may be missing at the end of a recording


def sent_and_used(
    traces: SessionTraces, recorded: Scenario, loops: Mapping[str, Loop], steps: Steps | None
) -> dict[str, tuple[Sent, Looks]]:
    """Return what is known of the links of a session, by name.

    A link is left out where its sender was started again or its packets were not recorded.
    """
    server = traces.server
    if server is None or steps is None or not has_waves(recorded.controller):
        return {}
    found: dict[str, tuple[Sent, Looks]] = {}
    ticks = max(len(loop.ran_ns) for loop in loops.values() if loop.ran_ns is not None)
    for old in recorded.users:
        user = next(user for user in traces.users if user.name == old.name)
        if old.name not in server.users:
            continue
        place, loop = server.users.index(old.name), loops[old.name]
        _, sends_ns = frame_events(loop, EventKind.SEND, ticks=ticks, tick_ns=0)
        sent = _sent(traces.packets.get(f"/{old.name}/wave_up"), sends_ns)
        if sent is not None:
            used = server.u_s[place][: len(steps.tick)]
            found[f"{old.name}/up"] = sent, Looks(steps.ran_ns, used)
        answers_ns = steps.ran_ns[server.state[place][: len(steps.tick)] > 0]
        sent = _sent(traces.packets.get(f"/server/{old.name}/wave_down"), answers_ns)
        if sent is not None:
            found[f"{old.name}/down"] = sent, _used_by_master(user, loop, ticks)
    return found


def _sent(packets: PacketTraces | None, times_ns: Integers) -> Sent | None:
    """Return the packets of a sender with the times it sent at, where all are there."""
    if packets is None or not len(packets.seq) or len(np.unique(packets.epoch)) > 1:
        return None
    count = min(len(packets.seq), len(times_ns))
    whole = np.array_equal(packets.seq[:count], np.arange(1, count + 1))
    if not whole or len(times_ns) - len(packets.seq) > FAR_OFF:
        return None
    return Sent(times_ns[:count], packets.wave[:count])


def _used_by_master(user: UserTraces, loop: Loop, ticks: int) -> Looks:
    """Return the waves a master used: what its hold has reached before the next answer."""
    tick, time_ns = frame_events(loop, EventKind.ANSWER, ticks=ticks, tick_ns=0)
    own = np.rint(user.time_s / user.tick_s).astype(np.int64)
    rows = np.searchsorted(own, tick[1:]) - 1
    return Looks(time_ns[:-1], user.v_m[rows])
