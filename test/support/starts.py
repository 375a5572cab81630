# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The start of a recorded live session: nobody spoke before every end had matched its others."""

import numpy as np

from pmwvc_analysis.recording.topics import source_of


def not_heard(traces):
    """Return the topics and links whose first packets were not relayed, recorded or taken in."""
    found = set(filter(None, (unknown(traces, link) for link in traces.fates)))
    found |= {topic for topic, packets in traces.packets.items() if packets.seq[0] != 1}
    links = {f"{user.name}/{way}" for user in traces.users for way in ("up", "down")}
    for link in links | set(traces.fates):
        numbers = np.unique(traces.fates[link].seq) if link in traces.fates else np.zeros(1)
        if not np.array_equal(numbers, np.arange(1, len(numbers) + 1)):
            found.add(link)
    return found | ({"/server"} if traces.server.step[0] != 1 else set())


def unknown(traces, link):
    """Return the topic that feeds a link where the link knows not all of its packets."""
    fates, sent = traces.fates[link], traces.packets.get(source_of(link))
    known = set(zip(fates.epoch.tolist(), fates.seq.tolist(), strict=True))
    last = dict(sorted(known))  # by sender
    every = [] if sent is None else zip(sent.epoch.tolist(), sent.seq.tolist(), strict=True)
    absent = {each for each in every if each[1] <= last.get(each[0], 0)} - known
    unrecorded = int(fates.number[-1]) - len(fates.number) if len(fates.number) else 0
    return sent.topic if len(absent) > unrecorded else None
