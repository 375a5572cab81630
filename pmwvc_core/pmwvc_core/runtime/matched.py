# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The number of remote ends that a node's own publishers and subscriptions have matched.

Discovery is not symmetric in time: the graph may show both ends of a topic while one of them does
not know the other yet, and what is sent then is lost without a trace. Only each end itself knows;
``~/matched`` asks it.
"""

import json
from collections.abc import Mapping

from rclpy.node import Node
from std_srvs.srv import Trigger

PUBLISHERS, SUBSCRIPTIONS = "publishers", "subscriptions"


def serve_matched(node: Node) -> None:
    """Offer ``~/matched``: its message is :func:`matched` as JSON."""

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        response.message = json.dumps(matched(node))
        return response

    node.create_service(Trigger, "~/matched", answer)


def matched(node: Node) -> dict[str, dict[str, int]]:
    """Return per own publisher the matched subscriptions, per own subscription the publishers."""
    return {
        PUBLISHERS: {end.topic_name: end.get_subscription_count() for end in node.publishers},
        SUBSCRIPTIONS: {end.topic_name: end.get_publisher_count() for end in node.subscriptions},
    }


def unmatched(
    matches: Mapping[str, Mapping[str, int]], ends: Mapping[str, tuple[int, int]]
) -> list[str]:
    """Return what a node lacks, in words.

    Parameters
    ----------
    ends
        Topic -> wanted numbers of publishers and subscribers.
    """
    found = []
    for side, other, wanted_index in (
        (PUBLISHERS, "subscribers", 1),
        (SUBSCRIPTIONS, "publishers", 0),
    ):
        for topic, count in matches[side].items():
            wanted = ends[topic][wanted_index] if topic in ends else 0
            if count < wanted:
                found.append(f"{topic}: {count} of {wanted} {other} matched")
    return found
