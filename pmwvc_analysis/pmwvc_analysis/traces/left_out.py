# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The packets that senders left out by a deadband: frames and steps beside the packets sent."""

import numpy as np

from pmwvc_analysis.traces.stages import stages
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import SessionTraces


def left_out(traces: SessionTraces, scenario: Scenario | None) -> dict[str, float]:
    """Return which ratio of a sender's packets was left out, by name of the link (user1/up), where
    it had a deadband.

    A master has a packet for every frame, which is a block of its trace; the server one for every
    step in which the user is there.
    """
    found: dict[str, float] = {}
    server = traces.server
    for link in with_deadband(traces, scenario):
        name, _, way = link.rpartition("/")
        sender = f"/{name}/wave_up" if way == "up" else f"/server/{name}/wave_down"
        packets = traces.packets.get(sender)
        count = sum(len(user.block_time_s) for user in traces.users if user.name == name)
        if way == "down":
            count = 0
            if server is not None and name in server.users:
                count = int(np.count_nonzero(server.state[server.users.index(name)]))
        if packets is not None and count:
            found[link] = max(1.0 - len(packets.seq) / count, 0.0)
    return found


def with_deadband(traces: SessionTraces, scenario: Scenario | None) -> list[str]:
    """Return the links whose sender had a deadband at some time, by name."""
    scenarios = [stage.scenario for stage in stages(traces, scenario)] if scenario else []
    ends = [
        (f"{user.name}/{way}", end.deadband.is_on)
        for each in scenarios
        for user in each.users
        for way, end in (("up", user.master), ("down", user.contact))
    ]
    return list(dict.fromkeys(link for link, is_on in ends if is_on))
