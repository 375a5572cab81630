# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The start of a recorded live session: nobody spoke before every end had matched its others."""

import numpy as np


def not_heard(traces):
    """Return the topics and links whose first packets were not relayed, recorded or taken in."""
    found = {topic for topic, count in traces.counts.items() if "not_relayed" in count}
    found |= {topic for topic, packets in traces.packets.items() if packets.seq[0] != 1}
    links = {f"{user.name}/{way}" for user in traces.users for way in ("up", "down")}
    for link in links | set(traces.fates):
        numbers = np.unique(traces.fates[link].seq) if link in traces.fates else np.zeros(1)
        if not np.array_equal(numbers, np.arange(1, len(numbers) + 1)):
            found.add(link)
    return found | ({"/server"} if traces.server.step[0] != 1 else set())
