# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The relay as a process, over real DDS: what goes in comes out, and the record tells it all."""

import signal

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from oracle import link_oracle
from support.peers import ros
from support.processes import NodeProcess
from support.relayed import Line, same

from pmwvc_core.network.in_flight import Cause, FateKind
from pmwvc_core.params import LinkParams
from pmwvc_core.transport.packet import intact, size_bytes

pytestmark = pytest.mark.integration
NETEM = "pmwvc_netem.node"


def test_what_goes_in_comes_out_once_in_order_unchanged_and_not_early():
    delay_s = 0.012
    parameters = {"user1.link.up": LinkParams(delay_s=delay_s)}
    with ros() as peer, NodeProcess(NETEM, parameters) as netem:
        line = Line(peer)
        line.meet()
        line.send_in_bursts(5)
        peer.until(lambda: same(line.received[-1][1], line.sent[-1][1]))
        assert len(line.received) > 200
        through = line.sent[-len(line.received) :]
        for (sent_ns, sent), (arrived_ns, arrived) in zip(through, line.received, strict=True):
            assert same(arrived, sent)
            assert arrived_ns - sent_ns >= delay_s * 1e9
        for row in line.records():
            assert row["time_due_ns"] - row["time_in_ns"] == delay_s * 1e9
            assert row["time_out_ns"] >= row["time_due_ns"]
            assert (row["epoch"], row["bytes"]) == (line.epoch, size_bytes(1))
        assert netem.stop() == 0


FATES = LinkParams(
    delay_s=0.01, jitter="gamma", jitter_s=0.004, jitter_correlation=0.5, ge_p=0.05, ge_r=0.4,
    duplicate=0.1, corrupt=0.1, corrupt_correlation=0.3, handover_s=0.05, handover_step_s=0.003,
    handover_outage=0.3, handover_outage_max_s=0.02, slot_max_s=0.004, keep_order=False,
)  # fmt: skip
LINES = {  # of link and topics; the random numbers of the link
    ("user1/up", ("/user1/wave_up", "/server/user1/wave_up")): (5, 0, 0),
    ("user2/down", ("/server/user2/wave_down", "/user2/wave_down")): (5, 1, 1),
}


def test_live_fates_are_those_of_an_independent_oracle_and_are_counted_at_the_receiver():
    """Each direction of each user has a stream of its own."""
    parameters = {"seed": 5, "users": ["user1", "user2"]}
    parameters |= {"link.up": FATES, "user2.link.down": FATES}
    with ros() as peer, NodeProcess(NETEM, parameters):
        for named, stream in LINES.items():
            line = Line(peer, *named)
            line.meet()
            line.send_in_bursts(10)
            out = sum(row["time_out_ns"] > 0 for row in line.records())
            peer.until(lambda: len(line.received) == out)  # noqa: B023
            assert_as_computed(line, stream)


def assert_as_computed(line, stream):
    rows = sorted(line.originals(), key=lambda row: row["seq"])
    copies = {row["seq"]: row for row in line.records() if row["fate"] == FateKind.DUPLICATE}
    time_ns = np.array([row["time_in_ns"] for row in rows])
    wanted = link_oracle.fates(FATES, stream, time_ns)
    lost = np.array([row["fate"] == FateKind.LOST for row in rows])
    assert (lost == wanted.lost).all() and lost.any()
    due_ns = np.array([row["time_due_ns"] for row in rows])
    assert np.abs(due_ns - wanted.due_ns).max() <= 2
    flips = np.array([row["cause"] == Cause.CORRUPTION for row in rows])
    assert (flips == wanted.corrupted).all() and flips.any()
    assert [row["seq"] in copies for row in rows] == wanted.copied.tolist()
    broken = sum(not intact(message) for _, message in line.received)
    flipped = flips.sum() + sum(row["cause"] == Cause.CORRUPTION for row in copies.values())
    assert broken == flipped
    assert {len(message) for _, message in line.received} == {size_bytes(1)}


def test_settings_change_while_running_and_wrong_ones_are_refused(tmp_path):
    trace = tmp_path / "delays.csv"
    trace.write_text("time,delay\n0,0.01\n0.1,0.02\n")
    with ros() as peer, NodeProcess(NETEM, {"users": ["user1", "user2"]}):
        line = Line(peer)
        line.meet()
        assert peer.set_parameters("/netem", {"user1.link.up.loss": 1}) == [""]
        line.send_in_bursts(1, size=10)
        assert {row["fate"] for row in line.originals()[-10:]} == {FateKind.LOST}
        refused = {
            "user1.link.up.loss": (1.5, "out of range Min: 0.0, Max: 1.0, value: 1.5"),
            "user1.link.up.jitter": ("sometimes", "must be one of none, uniform, normal, pareto"),
            "seed": (3, "Trying to set a read-only parameter: seed."),
            "preset": ("lte", "Trying to set a read-only parameter: preset."),
            "user1.link.up.jitter_s": (-1.0, "out of range Min: 0.0, Max: 10.0, value: -1.0"),
        }
        wrong = {name: value for name, (value, _) in refused.items()}
        reasons = peer.set_parameters("/netem", wrong)
        for (name, (_, words)), reason in zip(refused.items(), reasons, strict=True):
            assert name in reason and words in reason
        line.send_in_bursts(1, size=10)
        assert {row["fate"] for row in line.originals()[-10:]} == {FateKind.LOST}
        wanted = {"user1.link.up.delay_s": 0.016, "user1.link.up.loss": 0.0}
        assert peer.set_parameters("/netem", wanted) == [""] * 2
        line.send_in_bursts(1, size=10)
        assert {row["fate"] for row in line.originals()[-10:]} == {FateKind.DELIVERED}
        delays_ns = [row["time_due_ns"] - row["time_in_ns"] for row in line.originals()[-10:]]
        assert delays_ns == pytest.approx([16_000_000] * 10)
        (refusal,) = peer.set_parameters("/netem", {"user1.link.up.jitter": "trace"})
        assert refusal.startswith("user1.link.up.trace_file: ")
        wanted = {"user1.link.up.delay_s": 0.0, "user1.link.up.trace_file": str(trace)}
        wanted |= {"user1.link.up.jitter": "trace"}  # one after the other
        assert peer.set_parameters("/netem", wanted) == [""] * 3
        line.send_in_bursts(1, size=10)
        delays_ns = {row["time_due_ns"] - row["time_in_ns"] for row in line.originals()[-10:]}
        assert delays_ns <= {10_000_000, 20_000_000}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_in_order_with_the_record_complete(number):
    """Packets under way are in the record too, as never come out; and what is no message."""
    with ros() as peer, NodeProcess(NETEM) as netem:
        line = Line(peer)
        line.meet()
        for junk in (b"\x00\x01\x00\x00", b"\x00\x01\x00\x00" + bytes(20)):
            line.publisher.publish(junk)
        peer.until(lambda: sum(row["fate"] == FateKind.INVALID for row in line.records()) == 2)
        line.send()
        peer.until(lambda: same(line.received[-1][1], line.sent[-1][1]))
        peer.until(lambda: line.originals()[-1]["seq"] == len(line.sent))
        assert peer.set_parameters("/netem", {"user1.link.up.delay_s": 60.0}) == [""]
        known = len(line.originals())
        line.send(10)
        peer.until(lambda: line.reports("in flight 10"))
        assert netem.stop(number) == 0
        assert "Traceback" not in netem.output
        peer.until(lambda: len(line.originals()) == known + 10)
        late = line.originals()[-10:]
        assert all(row["time_out_ns"] == 0 and row["time_due_ns"] for row in late)


def test_health_is_reported():
    with ros() as peer, NodeProcess(NETEM, {"preset": "lte"}):
        health = peer.collect(DiagnosticArray, "/diagnostics", reliable=True)
        peer.until(lambda: health)
        (status,) = health[0].status
        assert (status.name, status.level) == ("/netem", b"\x00")
        assert status.message == "relaying 2 links"
        values = {entry.key: entry.value for entry in status.values}
        assert values["user1/up"] == "in 0, out 0, lost 0, dropped 0, in flight 0, invalid 0"


def test_a_wrong_setting_ends_its_process():
    with NodeProcess(NETEM, {"link.up.loss": 2.0}) as netem:
        assert netem.wait() == 2
        assert netem.output.startswith("netem: link.up.loss = 2.0")
        assert len(netem.lines) == 1
