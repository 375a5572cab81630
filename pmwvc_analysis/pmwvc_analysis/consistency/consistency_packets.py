# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether what masters and server counted is what their packets carried.

Only where every packet of one life of the sender is on record.
"""

import numpy as np

from pmwvc_analysis.consistency.numbers import missing_from
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import PacketTraces, SessionTraces


def packets(traces: SessionTraces, scenario: Scenario | None, *, waves: bool) -> list[str]:
    """Return every contradiction in words."""
    if not waves or scenario is None:
        return []
    found = []
    frames = {user.name: user.master.frame_s for user in scenario.users}
    for user in traces.users:
        sent = _whole(traces, f"/{user.name}/wave_up")
        if sent is not None and not (np.diff(user.tick) < 0).any():
            known = np.sort(np.concatenate([[0.0], sent.energy]))
            if (gap := missing_from(user.energy["u_tx"], known)) is not None:
                found.append(
                    f"{user.name}: the energy of u_tx is not that of its packets, {gap:.3g} J off"
                )
        heard = _whole(traces, f"/{user.name}/wave_down")
        if heard is not None and user.name in frames and not (np.diff(user.tick) < 0).any():
            power = np.sum(heard.wave**2, axis=-1) * frames[user.name] / 2.0
            known = np.sort(np.concatenate([[0.0], power]))
            gained = np.diff(user.energy["v_rx"])
            single = np.diff(user.block_time_s) < 1.5 * frames[user.name]
            if (gap := missing_from(gained[single], known)) is not None:
                found.append(
                    f"{user.name}: the energy of v_rx is not that of packets received, "
                    f"{gap:.3g} J off"
                )
    return found


def _whole(traces: SessionTraces, topic: str) -> PacketTraces | None:
    """Return the packets on a topic if they are of one sender and none is missing."""
    table = traces.packets.get(topic)
    if table is None or len(table.seq) == 0:
        return None
    if traces.counts.get(topic, {}).get("missing", 0) or len(np.unique(table.epoch)) > 1:
        return None
    return table
