# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Other programs on the domain of a live session: named and left out, never fatal."""

import json
import re
import signal
import subprocess
import sys

import pytest
from support.peers import ros
from support.sessions import ROOT, Running
from support.verdicts import judged_stable

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.salvage import Salvage, messages
from pmwvc_core.transport.packet import FLAG_LEAVING
from pmwvc_msgs.msg import MasterTrace, PacketFate, ServerTrace, Wave

pytestmark = pytest.mark.integration
FAILING = """
import sys
from pmwvc_bringup import __main__
from pmwvc_bringup.session import monitor

status, calls = monitor.Monitor.status, []

def fail(self):
    calls.append(status(self))
    if len(calls) == 8:
        raise IndexError("an error of the runner itself")
    return calls[-1]

monitor.Monitor.status = fail
sys.argv = ["pmwvc", "run", "carry_16ms", "--duration", "600", "--out", sys.argv[1]]
sys.exit(__main__.main())
"""
TRACES = {
    "/server/trace": (ServerTrace, [{}, {"users": ["user1", "x"], "dof": 3, "x_s": [1.0]}]),
    "/user1/trace": (MasterTrace, [{}, {"dof": 5, "f_applied": [1.0], "state": 9}]),
    "/user1/wave_up": (Wave, [{}, {"wave": [1.0, 2.0], "integral": [9.0], "epoch": 5, "seq": 1}]),
    "/netem/fates": (PacketFate, [{}, {"link": "user1/up", "first": 2**63, "seq": [1, 2]}]),
}


def whole(path):
    """Tell whether a file is."""
    salvage = Salvage()
    return len(list(messages(path.open("rb"), salvage))) > 0 and salvage.whole


def test_a_session_full_of_strangers_ends_in_order_with_a_report(tmp_path):
    with Running(tmp_path / "session", "carry_16ms", "--duration", 600) as session:
        domain = re.search(r"ROS_DOMAIN_ID=(\d+)", session.await_line("ROS_DOMAIN_ID"))[1]
        session.await_ticks()
        with ros(domain=int(domain)) as peer:
            ends = [
                (peer.publisher(kind, topic, reliable=True), [kind(**fields) for fields in odd])
                for topic, (kind, odd) in TRACES.items()
            ]
            peer.until(lambda: all(end.get_subscription_count() for end, _ in ends))
            for _ in range(50):
                for end, odd in ends:
                    for message in odd:
                        end.publish(message)
            assert all(end.wait_for_all_acked() for end, _ in ends)
        session.process.send_signal(signal.SIGINT)
        assert session.end() == 0, session.output()
        assert session.nodes() == {}
        assert "Traceback" not in session.output()
    assert whole(session.folder / "session.mcap")
    judged_stable(session)
    words = [ROOT / "pmwvc", "doctor", session.folder]
    said = subprocess.run(words, capture_output=True, text=True, check=False).stdout
    # one or more: what a slow recorder takes of 100
    assert re.search(r"\d messages? on /server/trace whose fields do not fit", said), said


def test_an_error_of_the_runner_itself_still_stops_devices_first_and_closes_the_file(tmp_path):
    folder = tmp_path / "session"
    words = [sys.executable, "-c", FAILING, folder]
    result = subprocess.run(words, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert "an error of the runner itself" in result.stderr
    assert whole(folder / "session.mcap")
    assert json.loads((folder / "events.json").read_text("utf-8")) == []
    store, last = schemas.typestore(), {}
    for message in messages((folder / "session.mcap").open("rb"), Salvage()):
        if message.topic.endswith("/wave_up"):
            last[message.topic] = store.deserialize_cdr(message.data, schemas.WAVE)
    assert len(last) == 4
    assert all(packet.flags & FLAG_LEAVING for packet in last.values())  # also past the emulator
