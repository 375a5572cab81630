# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of a relayed topic of Waves, and the record of its link."""

import time

from diagnostic_msgs.msg import DiagnosticArray

from pmwvc_core.network.in_flight import FateKind
from pmwvc_core.runtime.topics import wave_bytes
from pmwvc_core.transport.packet import Admission, WavePacket
from pmwvc_msgs.msg import PacketFate, Wave

UP = ("/user1/wave_up", "/server/user1/wave_up")


class Line:
    """Both ends of one relayed topic of Waves, and the record of its link."""

    def __init__(self, peer, link="user1/up", topics=UP, epoch=11):
        self.peer, self.link, self.epoch = peer, link, epoch
        self.publisher = peer.publisher(Wave, topics[0])
        self.seal = Admission(None, out="up", into="down")
        self.sent = []  # (time before publishing [ns], bytes), by number - 1
        self.received = []  # (time of arrival [ns], bytes)
        self.blocks = peer.collect(PacketFate, "/netem/fates", reliable=True)
        self.health = peer.collect(DiagnosticArray, "/diagnostics", reliable=True)
        peer.subscribe(Wave, topics[1], self._receive, raw=True)

    def _receive(self, message):
        self.received.append((time.monotonic_ns(), message))

    def meet(self):
        """Wait until both ends and the record are joined: until a packet has come through.

        The first ones may find no relay yet: then they are not in its record.
        """
        self.peer.until(lambda: self.health and self.publisher.get_subscription_count())
        self.peer.until(lambda: self.send() and self.received)
        self.peer.until(self.settled)

    def send(self, count=1):
        for _ in range(count):
            packet = WavePacket(self.epoch, len(self.sent) + 1, 5, 0.008, 0.5, 0.1, 0.2, 0.3)
            message = self.seal.sealed(wave_bytes(packet, time.time_ns()))
            self.sent.append((time.monotonic_ns(), message))
            self.publisher.publish(message)
        return count

    def send_in_bursts(self, bursts, size=40):
        """Send; after each burst wait until all of it is in the record."""
        for _ in range(bursts):
            self.send(size)
            self.peer.until(self.settled)

    def settled(self):
        """Tell whether every packet since the first recorded one is in the record."""
        numbers = [row["seq"] for row in self.originals()]
        return bool(numbers) and len(numbers) == len(self.sent) - min(numbers) + 1

    def records(self):
        """Return the record as a list of dictionaries, in the order of ``first``."""
        names = (
            "epoch",
            "seq",
            "bytes",
            "time_in_ns",
            "time_due_ns",
            "time_out_ns",
            "fate",
            "cause",
        )
        blocks = sorted((b for b in self.blocks if b.link == self.link), key=lambda b: b.first)
        rows = []
        for block in blocks:
            assert block.first == len(rows) + 1  # nothing missing, nothing twice
            columns = [getattr(block, name) for name in names]
            rows += [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]
        return rows

    def reports(self, text):
        """Tell whether the relay has reported that of its link."""
        statuses = [status for array in self.health for status in array.status]
        found = [v.value for s in statuses for v in s.values if v.key == self.link]
        return any(text in value for value in found)

    def originals(self):
        return [row for row in self.records() if row["fate"] != FateKind.DUPLICATE]


def same(arrived, sent):
    """Tell whether a message arrived as it was sent; the transport fills it up to whole words."""
    return arrived[: len(sent)] == sent and len(arrived) - len(sent) < 4
