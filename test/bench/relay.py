# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The emulator under load: 4 links of 1 kHz, what it loses and what it adds."""

import time

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from support.peers import ros
from support.processes import NodeProcess

from pmwvc_core.params import LinkParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.pacing import Pacer
from pmwvc_core.transport.packet import WavePacket
from pmwvc_msgs.msg import PacketFate, Wave

USERS, RATE_HZ = ["user1", "user2"], 1000
TOPICS = [t for u in USERS for t in (f"/{u}/wave_up", f"/server/{u}/wave_down")]
DELAY_S = 0.02
QOS = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)


def bench_relay(duration_s):
    """Return sent, taken in and given out packets, and the error of the delay [ms]."""
    links = {f"link.{way}": LinkParams(delay_s=DELAY_S) for way in ("up", "down")}
    parameters = {"users": USERS, **links}
    packet, types = WavePacket(1, 1, 5, 0.008, 1.0, 1.0, 1.0, 1.0), messages.live_types()
    message = serialize_message(messages.wave(types, packet, 1))
    with ros() as peer, NodeProcess("pmwvc_netem.node", parameters) as netem:
        publishers = [peer.node.create_publisher(Wave, topic, QOS) for topic in TOPICS]
        blocks = peer.collect(PacketFate, "/netem/fates", reliable=True)
        health = peer.collect(DiagnosticArray, "/diagnostics", reliable=True)
        peer.until(lambda: health and all(p.get_subscription_count() for p in publishers))
        pacer = Pacer(round(1e9 / RATE_HZ))
        for tick in range(int(duration_s * RATE_HZ)):
            pacer.wait()
            for publisher in publishers:
                publisher.publish(message)
            if not tick % 50:
                peer.until(lambda: True)
        sent = len(TOPICS) * int(duration_s * RATE_HZ)
        end_s = time.monotonic() + 2.0
        peer.until(lambda: time.monotonic() > end_s)
        netem.stop()
    errors = np.concatenate(
        [np.subtract(b.time_out_ns, b.time_due_ns)[np.array(b.time_out_ns) > 0] for b in blocks]
    )
    return {
        "sent": sent,
        "taken_in": sum(len(b.seq) for b in blocks),
        "given_out": sum(np.count_nonzero(b.time_out_ns) for b in blocks),
        "bytes": int(blocks[0].bytes[0]),
        "error_p50_ms": float(np.median(errors)) * 1e-6,
        "error_p99_ms": float(np.percentile(errors, 99)) * 1e-6,
        "error_max_ms": float(errors.max()) * 1e-6,
    }
