# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a node with a loop knows of itself and of its links: for its diagnostics, once a second;
for a recorder, twice a second and once at the end. The publishers on its topics: none, another
one, more than one; and, for its terminal, packets that another token has sealed.
"""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from rclpy.node import Node

from pmwvc_core.runtime.messages import live_types, time_message
from pmwvc_core.runtime.pacing import granted_words
from pmwvc_core.runtime.topics import OF_TOKENS, RECORDED_QOS
from pmwvc_core.transport.packet import Receipt
from pmwvc_core.transport.receiver import Receiver, counts, passage
from pmwvc_core.words import count

PERIOD_S = 0.5
PATIENCE_S = 3.0  # without a packet, before it is worth a warning
SUSPECT = {  # verdicts that are worth a warning while packets of the sender come
    Receipt.STRANGER: "of another sender refused",
    Receipt.OTHER_SESSION: "of another session refused: session.token_file must be of one "
    "'pmwvc token' at both ends, or empty at both",
    Receipt.FORGED: "refused: the user's token (session.token_file) did not seal them",
    Receipt.FLOOD: "beyond the rate of a sender refused",
    Receipt.CORRUPTED: "corrupted on their way",
}


class Peers:
    """Watches wave topics by their full names: those of receivers (``inboxes``), and ``own`` ones,
    which no other node should publish. ``publishers`` returns the nodes of a topic, ``clock`` [s];
    ``warn`` is told of packets of a wrong token when they begin, and again after a pause.
    """

    def __init__(
        self, publishers: Callable[[str], Sequence[str]], *, inboxes: Mapping[str, Receiver],
        own: Sequence[str], warn: Callable[[str], object],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        self._publishers, self._inboxes, self._own = publishers, dict(inboxes), list(own)
        self._clock, self._begin_s, self._warn = clock, clock(), warn
        self._before = {(topic, each): (0, False) for topic in self._inboxes for each in SUSPECT}

    def look(self) -> tuple[list[str], dict[str, object]]:
        """Return what is wrong, one clause each, and values for people by name."""
        wrong, values = list[str](), dict[str, object]()
        for topic, inbox in self._inboxes.items():
            names = sorted(self._publishers(topic))
            values[f"{topic}: publishers"] = ", ".join(names) or "none"
            values[f"{topic}: sender followed"] = f"{inbox.epoch:016x}" if inbox.epoch else "none"
            found = self._of_packets(topic, names, inbox)
            wrong += _several(topic, names) or found
        for topic in self._own:
            wrong += _several(topic, sorted(self._publishers(topic)))
        return wrong, values

    def _of_packets(self, topic: str, names: Sequence[str], inbox: Receiver) -> list[str]:
        wrong = []
        for verdict, words in SUSPECT.items():
            key, number = (topic, verdict), inbox.counts[verdict]
            before, again = self._before[key]
            self._before[key] = number, number > before
            if number > before:
                wrong.append(f"{topic}: {count(number - before, 'packet')} {words}")
                if verdict in OF_TOKENS and not again:
                    self._warn(wrong[-1])
        if wrong or inbox.newest is not None or self._clock() - self._begin_s < PATIENCE_S:
            return wrong
        taken = (Receipt.ACCEPTED, Receipt.NEW_EPOCH)
        refused = [f"{n} {v.value}" for v, n in inbox.counts.items() if n and v not in taken]
        if refused:
            return [f"every packet on {topic} was refused: {', '.join(refused)}"]
        return [_nothing_on(topic, names)]


def _several(topic: str, names: Sequence[str]) -> list[str]:
    return [f"{len(names)} publishers on {topic}: {', '.join(names)}"] * (len(names) > 1)


def _nothing_on(topic: str, names: Sequence[str]) -> str:
    """Return why no packet comes on a topic with these publishers."""
    if names:
        return f"no packets on {topic}, published by {', '.join(names)}"
    domain = os.environ.get("ROS_DOMAIN_ID") or "0"
    return (
        f"no packets on {topic}: no publisher in ROS domain {domain}; is the other node "
        "running, in the same domain and namespace?"
    )


def publishers_of(node: Node) -> Callable[[str], Sequence[str]]:
    """Return what lists the publishers of a topic, as a ROS node sees them."""
    return lambda topic: [
        f"{info.node_namespace.rstrip('/')}/{info.node_name}"
        for info in node.get_publishers_info_by_topic(topic)
    ]


class Watch:
    """Looks at a loop that counts its ``health`` and deadlines ``missed``, and publishes on topic
    ``reception`` what came by its ``links``: topic in, topic out and receiver by name.
    """

    def __init__(
        self, node: Node, loop: Any, *, links: Mapping[str, tuple[str, str, Receiver]],
        reception: str, epoch: int,
    ) -> None:  # fmt: skip
        self._node, self._loop, self._epoch, self._seq = node, loop, epoch, 0
        self._looked_s, self._missed = time.monotonic(), loop.missed
        full = node.resolve_topic_name
        self.peers = Peers(
            publishers_of(node),
            inboxes={full(incoming): inbox for incoming, _, inbox in links.values()},
            own=[full(outgoing) for _, outgoing, _ in links.values()],
            warn=node.get_logger().warning,
        )
        self._inboxes = {link: inbox for link, (_, _, inbox) in links.items()}
        self._types = live_types()
        self._out = node.create_publisher(self._types.Reception, reception, RECORDED_QOS)

    def begin(self) -> None:
        """Publish from now on; until a session begins, a recorder may not have been matched."""
        self._node.create_timer(PERIOD_S, self.publish)

    def publish(self) -> None:
        """Publish what has been received until now."""
        types, others = self._types, self._loop.protocol.other_controller
        for link, inbox in self._inboxes.items():
            self._seq += 1
            stamp = time_message(types, time.time_ns())
            head = {"stamp": stamp, "epoch": self._epoch, "seq": self._seq, "sender": inbox.epoch}
            received = counts(inbox, other_controller=others) | passage(inbox.path.estimate())
            self._out.publish(types.Reception(link=link, **head, **received))

    def look(self) -> tuple[dict[str, object], int]:
        """Return values for people by name, and the deadlines missed since the last look."""
        loop, now_s = self._loop, time.monotonic()
        took_ns, loop.took_ns = loop.took_ns, []
        elapsed_s, self._looked_s = now_s - self._looked_s, now_s
        missed, self._missed = loop.missed - self._missed, loop.missed
        took_us = np.array(took_ns).reshape(-1, 2) * 1e-3
        found: dict[str, object] = {"rate [Hz]": f"{len(took_us) / elapsed_s:.1f}"}
        for name, each in zip(("lateness", "compute"), took_us.T, strict=True):
            found[f"{name} mean [us]"] = f"{each.sum() / max(len(each), 1):.1f}"
            found[f"{name} max [us]"] = f"{each.max(initial=0.0):.1f}"
        return found | {
            "missed deadlines": loop.missed,
            "packets of another controller": loop.protocol.other_controller,
            "real time": granted_words(loop.report),
        }, missed
