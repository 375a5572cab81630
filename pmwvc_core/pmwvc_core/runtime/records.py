# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a node publishes for a recorder: kept at the sender, and sent again to one that missed it.

Packets go to the other end with best effort, once. What is sent again would fill the queues of the
loops: packets for the recorder have a topic of their own. Works without ROS.
"""

KEPT = 10_000  # messages of a topic: ten seconds at 1 kHz


def record_of(topic: str) -> str:
    """Return the topic on which a sender of waves publishes each once more, for the recorder."""
    return f"{topic}/sent"
