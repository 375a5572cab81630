# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a node with a loop knows of itself and of its links: for its diagnostics, once a second;
for a recorder, twice a second and once at the end; wrong tokens at its terminal as well.
"""

import time
from collections.abc import Mapping
from typing import Any

from rclpy.node import Node

from pmwvc_core.runtime.messages import live_types, time_message
from pmwvc_core.runtime.pacing import Health
from pmwvc_core.runtime.peers import Peers, WrongTokens, publishers_of
from pmwvc_core.runtime.topics import RECORDED_QOS
from pmwvc_core.transport.receiver import Receiver
from pmwvc_core.transport.reception import counts, passage

PERIOD_S = 0.5


class Watch:
    """Looks at a loop that counts its ``health`` and deadlines ``missed``, and publishes on topic
    ``reception`` what it has received.

    ``links`` are topic in, topic out and receiver of each link by name; ``epoch`` is the node's.
    """

    def __init__(
        self,
        node: Node,
        loop: Any,
        *,
        links: Mapping[str, tuple[str, str, Receiver]],
        reception: str,
        epoch: int,
    ) -> None:
        self._node, self._loop, self._epoch, self._seq = node, loop, epoch, 0
        self._looked_s, self._missed = time.monotonic(), loop.missed
        full = node.resolve_topic_name
        self.peers = Peers(
            publishers_of(node),
            inboxes={full(incoming): inbox for incoming, _, inbox in links.values()},
            own=[full(outgoing) for _, outgoing, _ in links.values()],
        )
        self._inboxes = {link: inbox for link, (_, _, inbox) in links.items()}
        self._wrong_tokens = WrongTokens(self._inboxes)
        self._types = live_types()
        self._out = node.create_publisher(self._types.Reception, reception, RECORDED_QOS)

    def begin(self) -> None:
        """Publish from now on; until a session begins, a recorder may not have been matched."""
        self._node.create_timer(PERIOD_S, self.publish)

    def publish(self) -> None:
        """Publish what has been received until now."""
        for sentence in self._wrong_tokens.look():
            self._node.get_logger().warning(sentence)
        for link, inbox in self._inboxes.items():
            self._seq += 1
            self._out.publish(
                self._types.Reception(
                    stamp=time_message(self._types, time.time_ns()),
                    epoch=self._epoch,
                    seq=self._seq,
                    link=link,
                    sender=inbox.epoch,
                    **counts(inbox, other_controller=self._loop.protocol.other_controller),
                    **passage(inbox.path.estimate()),
                )
            )

    def look(self) -> tuple[dict[str, object], int]:
        """Return values for people by name, and how many deadlines were missed since the last
        look.
        """
        loop, now_s = self._loop, time.monotonic()
        health, loop.health = loop.health, Health()
        elapsed_s, self._looked_s = now_s - self._looked_s, now_s
        missed, self._missed = loop.missed - self._missed, loop.missed
        ticks_us = 1e3 * max(health.ticks, 1)
        return {
            "rate [Hz]": f"{health.ticks / elapsed_s:.1f}",
            "lateness mean [us]": f"{health.late_sum_ns / ticks_us:.1f}",
            "lateness max [us]": f"{health.late_max_ns / 1e3:.1f}",
            "compute mean [us]": f"{health.compute_sum_ns / ticks_us:.1f}",
            "compute max [us]": f"{health.compute_max_ns / 1e3:.1f}",
            "missed deadlines": loop.missed,
            "packets of another controller": loop.protocol.other_controller,
            "real time": str(loop.report or "not requested yet"),
        }, missed
