# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The services of every node: ``~/start`` lets its work begin, ``~/matched`` tells how many remote
ends its own publishers and subscriptions have matched, which only the node itself knows.
"""

import json
import threading
import time
from collections.abc import Mapping, Sequence

from rclpy.node import Node
from std_srvs.srv import Trigger

from pmwvc_core.params import Spec
from pmwvc_core.runtime.parameters import declare_value

PUBLISHERS, SUBSCRIPTIONS = "publishers", "subscriptions"
OF_SESSION = ("trace", "wave_up", "wave_down")  # last names of the topics that matter at the start
SETTLE_S = 0.3  # the other ends have matched as well by then
LONGEST_S = 10.0


class StartGate:
    """Holds a node's work back until it is started, or until its topics have found their other
    ends (where it joins a running session; for ``LONGEST_S`` at most); offers both services.
    """

    def __init__(self, node: Node) -> None:
        paused = Spec(bool, description="wait for a call of ~/start before the first tick")
        joins = Spec(bool, description="wait until waves and trace have found their other ends")
        least = Spec(int, low=1, description="subscribers of the trace to wait for when joining")
        self._node, self._open = node, threading.Event()
        if not declare_value(node, "start.paused", paused, False):
            self._open.set()
        self._joins = declare_value(node, "start.joins", joins, False)
        self._listeners = declare_value(node, "start.listeners", least, 1)
        node.create_service(Trigger, "~/start", self._start)
        node.create_service(Trigger, "~/matched", self._matched)

    def wait(self, stop: threading.Event) -> bool:
        """Wait until started or stopped; return whether started."""
        until_s = time.monotonic() + LONGEST_S
        while not stop.wait(0.02):
            late = time.monotonic() > until_s
            if self._open.is_set() and (late or not self._joins or self._found()):
                return not (self._joins and stop.wait(SETTLE_S))
        return False

    def _found(self) -> bool:
        """Tell whether each topic of the session has another end, and the trace its listeners."""
        known = matched(self._node)
        ends = [end for side in known.values() for end in side.items()]
        counts = [n for topic, n in ends if topic.rpartition("/")[2] in OF_SESSION]
        traces = [n for topic, n in known[PUBLISHERS].items() if topic.endswith("/trace")]
        return all(counts) and min(traces, default=self._listeners) >= self._listeners

    def _start(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = "already running" if self._open.is_set() else "started"
        response.success = True
        self._open.set()
        return response

    def _matched(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success, response.message = True, json.dumps(matched(self._node))
        return response


def matched(node: Node) -> dict[str, dict[str, int]]:
    """Return per own publisher the matched subscriptions, per own subscription the publishers."""
    return {
        PUBLISHERS: {end.topic_name: end.get_subscription_count() for end in node.publishers},
        SUBSCRIPTIONS: {end.topic_name: end.get_publisher_count() for end in node.subscriptions},
    }


def unmatched(matches: Mapping[str, Mapping[str, int]], topics: Sequence[str]) -> list[str]:
    """Return which of some topics have no other end of a node's publishers or subscriptions."""
    return [
        f"{topic}: no {other} matched"
        for side, other in ((PUBLISHERS, "subscriber"), (SUBSCRIPTIONS, "publisher"))
        for topic, count in matches[side].items()
        if topic in topics and not count
    ]
