# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The emulator under load: 4 links of 1 kHz and 200 bytes, what it loses and what it adds."""

import time

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import UInt8MultiArray
from support.processes import NodeProcess, ros

from pmwvc_core.params import LinkParams
from pmwvc_core.runtime.pacing import Pacer
from pmwvc_msgs.msg import PacketFate

LINKS, RATE_HZ, BYTES, HEAD = 4, 1000, 200, 16  # HEAD: encapsulation and lengths of the message
DELAY_S = 0.02
QOS = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)


def bench_relay(duration_s):
    """Return sent, taken in and given out packets, and the error of the delay [ms]."""
    names = [f"load{n}" for n in range(LINKS)]
    parameters = {"link_names": names}
    for name in names:
        parameters[f"links.{name}"] = LinkParams(delay_s=DELAY_S)
        parameters[f"links.{name}.type"] = "std_msgs/msg/UInt8MultiArray"
        parameters[f"links.{name}.from"] = f"/{name}/in"
        parameters[f"links.{name}.to"] = f"/{name}/out"
    message = UInt8MultiArray(data=bytes(BYTES - HEAD))
    with ros() as peer, NodeProcess("pmwvc_netem.node", parameters) as netem:
        publishers = [
            peer.node.create_publisher(UInt8MultiArray, f"/{name}/in", QOS) for name in names
        ]
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
        sent = LINKS * int(duration_s * RATE_HZ)
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
