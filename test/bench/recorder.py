# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Messages lost by the recorder while other programs keep the machine busy.

::

    python test/bench/recorder.py --users 8 --seconds 30 --busy 2

One process publishes the waves and traces of so many users at their rates (packets and blocks of
eight ticks, one every 8 ms, sizes as in a session of one axis); ``--busy`` loops run beside it.
Printed are what is missing, the recorder's processor time, and its memory at the beginning and at
the end.
"""

import argparse
import os
import struct
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from support.processes import NodeProcess, ros

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.salvage import Salvage, messages
from pmwvc_analysis.recording.topics import session_topics
from pmwvc_core.runtime.pacing import Pacer, hold_memory, request_real_time
from pmwvc_msgs.msg import MasterTrace, PacketFate, ServerTrace, Wave

FRAME_NS = 8_000_000
NUMBER_AT = 28  # CDR header, stamp, clock, epoch
CLASSES = {
    schemas.WAVE: Wave,
    schemas.MASTER_TRACE: MasterTrace,
    schemas.SERVER_TRACE: ServerTrace,
    schemas.PACKET_FATE: PacketFate,
}


def data(type_name: str, users: int) -> bytearray:
    """Return a message of the size that a session has; its numbers do not compress."""
    sizes = {schemas.WAVE: 110, schemas.MASTER_TRACE: 760, schemas.SERVER_TRACE: 120 + 70 * users}
    head = b"\0\1\0\0" + struct.pack("<iIqQQ", 1, 1, 1, 9, 0)
    return bytearray(head + os.urandom(sizes[type_name]))


def resident_mib(pid: int) -> float:
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def processor_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main() -> int:
    """Run the measurement; 1 when something is missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--users", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--busy", type=int, default=2)
    options = parser.parse_args()
    users = [f"user{number + 1}" for number in range(options.users)]
    links = [f"{user}/{way}" for user in users for way in ("up", "down")]
    folder = Path(tempfile.mkdtemp(prefix="recorder-")) / "session"
    settings = {"folder": str(folder), "users": users, "people": False}
    busy = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(options.busy)
    ]
    try:
        with ros() as peer, NodeProcess("pmwvc_analysis.recorder_node", settings) as recorder:
            ends = []
            for topic in filter(lambda topic: topic.essential, session_topics(users, links=links)):
                publisher = peer.publisher(
                    CLASSES[topic.type_name], topic.name, reliable=topic.reliable
                )
                if topic.type_name != schemas.PACKET_FATE:
                    ends.append((publisher, data(topic.type_name, options.users)))
            recorder.await_output("^ready$")
            peer.until(lambda: all(end.get_subscription_count() for end, _ in ends))
            pid = recorder.process.pid
            before = resident_mib(pid)
            hold_memory()
            request_real_time(20)
            pacer = Pacer(FRAME_NS)
            frames = round(options.seconds * 1e9) // FRAME_NS
            for number in range(1, frames + 1):
                pacer.wait()
                for publisher, content in ends:
                    struct.pack_into("<I", content, NUMBER_AT, number)
                    publisher.publish(bytes(content))
            after, used = resident_mib(pid), processor_s(pid)
            threading.Event().wait(1.0)  # what is under way arrives
            recorder.stop()
    finally:
        for process in busy:
            process.kill()
    offered = frames * len(ends)
    missing = offered - sum(1 for _ in messages((folder / "session.mcap").open("rb"), Salvage()))
    print(f"{options.users} users, {options.busy} busy loops, {options.seconds:g} s")
    print(f"missing: {missing} of {offered} messages")
    print(f"recorder: {used / options.seconds:.1%} of a core, {before:.1f} to {after:.1f} MiB")
    return int(missing > 0)


if __name__ == "__main__":
    sys.exit(main())
