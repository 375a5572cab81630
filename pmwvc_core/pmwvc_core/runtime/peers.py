# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The publishers on the topics of a node, for its diagnostics: none, another one, more than one;
and for its terminal the packets that another token has sealed.

Needs no ROS: whatever lists the publishers of a topic is an argument.
"""

import os
import time
from collections.abc import Callable, Mapping, Sequence

from pmwvc_core.plural import count
from pmwvc_core.transport.packet import Verdict
from pmwvc_core.transport.receiver import Receiver

PATIENCE_S = 3.0  # without a packet, before it is worth a warning
SUSPECT = {  # verdicts that are worth a warning while packets of the sender come
    Verdict.STRANGER: "of another sender refused",
    Verdict.OTHER_SESSION: "of another session refused",
    Verdict.FORGED: "without the user's token refused",
    Verdict.FLOOD: "beyond the rate of a sender refused",
    Verdict.CORRUPTED: "corrupted on their way",
}
OF_TOKENS = {
    Verdict.OTHER_SESSION: "of another session are refused: session.token_file must be of one "
    "'pmwvc token' at both ends, or empty at both",
    Verdict.FORGED: "are refused: the user's token (session.token_file) did not seal them",
}
REFUSED = [v for v in Verdict if v not in (Verdict.ACCEPTED, Verdict.NEW_EPOCH)]


class Peers:
    """Watches the wave topics of one node, by their full names: those of its receivers
    (``inboxes``), and its ``own``, which no other node should publish.

    ``publishers`` returns the full names of the nodes that publish a topic, ``clock`` monotonic
    time [s].
    """

    def __init__(
        self,
        publishers: Callable[[str], Sequence[str]],
        *,
        inboxes: Mapping[str, Receiver],
        own: Sequence[str],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._publishers, self._inboxes, self._own = publishers, dict(inboxes), list(own)
        self._clock, self._begin_s = clock, clock()
        self._before = {(topic, verdict): 0 for topic in self._inboxes for verdict in SUSPECT}

    def look(self) -> tuple[list[str], dict[str, object]]:
        """Return what is wrong, one clause each, and values for people by name."""
        wrong: list[str] = []
        values: dict[str, object] = {}
        for topic, inbox in self._inboxes.items():
            names = sorted(self._publishers(topic))
            others = [f"{epoch:016x} ({n} packets)" for epoch, n in inbox.strangers.items()]
            values[f"{topic}: publishers"] = ", ".join(names) or "none"
            values[f"{topic}: sender followed"] = f"{inbox.epoch:016x}" if inbox.epoch else "none"
            values[f"{topic}: other senders"] = ", ".join(others) or "none"
            wrong += _several(topic, names) or self._of_packets(topic, names, inbox)
        for topic in self._own:
            wrong += _several(topic, sorted(self._publishers(topic)))
        return wrong, values

    def _of_packets(self, topic: str, names: Sequence[str], inbox: Receiver) -> list[str]:
        wrong = []
        for verdict, words in SUSPECT.items():
            key, number = (topic, verdict), inbox.counts[verdict]
            before, self._before[key] = self._before[key], number
            if number > before:
                wrong.append(f"{count(number - before, 'packet')} {words} on {topic}")
        if wrong or inbox.newest is not None or self._clock() - self._begin_s < PATIENCE_S:
            return wrong
        refused = [f"{inbox.counts[v]} {v.value}" for v in REFUSED if inbox.counts[v]]
        if refused:
            return [f"every packet on {topic} was refused: {', '.join(refused)}"]
        return [nothing_on(topic, names)]


class WrongTokens:
    """Finds receivers, given by link, that begin to refuse packets because of their tokens."""

    def __init__(self, inboxes: Mapping[str, Receiver]) -> None:
        self._inboxes = dict(inboxes)
        self._seen = {(link, verdict): (0, False) for link in inboxes for verdict in OF_TOKENS}

    def look(self) -> list[str]:
        """Return a sentence for each link and reason that was not there at the last look."""
        found = []
        for (link, verdict), (before, refused) in self._seen.items():
            number = self._inboxes[link].counts[verdict]
            if number > before and not refused:
                found.append(f"{link}: packets {OF_TOKENS[verdict]}")
            self._seen[link, verdict] = number, number > before
        return found


def _several(topic: str, names: Sequence[str]) -> list[str]:
    several = f"{len(names)} publishers on {topic}: {', '.join(names)}"
    return [several] if len(names) > 1 else []


def nothing_on(topic: str, names: Sequence[str]) -> str:
    """Return why no packet comes on a topic with these publishers."""
    if names:
        return f"no packets on {topic}, published by {', '.join(names)}"
    domain = os.environ.get("ROS_DOMAIN_ID") or "0"
    return (
        f"no packets on {topic}: no publisher in ROS domain {domain}; is the other node "
        "running, in the same domain and namespace?"
    )


def publishers_of(node: object) -> Callable[[str], Sequence[str]]:
    """Return what lists the publishers of a topic, as a ROS node sees them."""

    def names(topic: str) -> list[str]:
        infos = node.get_publishers_info_by_topic(topic)  # type: ignore[attr-defined]
        return [f"{info.node_namespace.rstrip('/')}/{info.node_name}" for info in infos]

    return names
