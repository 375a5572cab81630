# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The publisher of what a node's receivers have received, twice a second and once at the end;
wrong tokens are said at its terminal as well.
"""

import time
from collections.abc import Callable, Mapping

from rclpy.node import Node

from pmwvc_core.runtime import messages
from pmwvc_core.runtime.peers import WrongTokens
from pmwvc_core.runtime.polling import RECORDED_QOS
from pmwvc_core.transport.receiver import Receiver
from pmwvc_core.transport.reception import counts, passage

PERIOD_S = 0.5


class Receptions:
    """Publishes on one topic for all links of a node: its receivers by link, and how many packets
    of another kind of controller came over all of them.
    """

    def __init__(
        self,
        node: Node,
        topic: str,
        *,
        inboxes: Mapping[str, Receiver],
        epoch: int,
        other_controller: Callable[[], int],
    ) -> None:
        self._node = node
        self._types = messages.live_types()
        self._inboxes = dict(inboxes)
        self._wrong_tokens = WrongTokens(inboxes)
        self._epoch = epoch
        self._other_controller = other_controller
        self._seq = 0
        self._out = node.create_publisher(self._types.Reception, topic, RECORDED_QOS)

    def begin(self) -> None:
        """Publish from now on; until a session begins, a recorder may not have been matched."""
        self._node.create_timer(PERIOD_S, self.publish)

    def publish(self) -> None:
        """Publish what there is now."""
        for sentence in self._wrong_tokens.look():
            self._node.get_logger().warning(sentence)
        for link, inbox in self._inboxes.items():
            self._seq += 1
            self._out.publish(
                messages.reception(
                    self._types,
                    stamp_ns=time.time_ns(),
                    epoch=self._epoch,
                    seq=self._seq,
                    link=link,
                    sender=inbox.epoch,
                    **counts(inbox, other_controller=self._other_controller()),
                    **passage(inbox.path.estimate()),
                )
            )
