# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The start of a recorded live session: nobody spoke before every end had matched its others."""

import numpy as np


def everybody_was_there(traces):
    """Assert that the first packet of every end was relayed, recorded and taken in."""
    assert not any("not_relayed" in count for count in traces.counts.values())
    names = [user.name for user in traces.users]
    assert set(traces.fates) == {f"{name}/{way}" for name in names for way in ("up", "down")}
    for link, fates in traces.fates.items():
        numbers = np.unique(fates.seq)
        assert numbers.tolist() == list(range(1, len(numbers) + 1)), link
    for topic, packets in traces.packets.items():
        assert packets.seq[0] == 1, topic
    assert traces.server.step[0] == 1
