# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The schedule of the force loop on an invented grid: no clock, no ROS."""

import math
import sys
import threading

import pytest
from support.loop_rig import FRAME_S, TICK_NS, TICKS, Rig
from support.packer import Packer

from pmwvc_core.errors import DeviceError
from pmwvc_core.law.port.master import port_signals
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.params import MasterParams, SafetyParams
from pmwvc_core.runtime import pacing
from pmwvc_core.transport.packet import FLAG_LEAVING


def test_the_loop_begins_with_a_whole_frame():
    rig = Rig()
    rig.ticks(*range(3, 8))
    assert not rig.wires.sent and not rig.device.forces
    rig.tick(8)
    assert len(rig.wires.sent) == 1 and len(rig.device.forces) == 1


def test_another_rate_begins_with_the_next_frame_and_lies_on_its_own_grid():
    rig = Rig(rate_drop=8)
    rig.ticks(*range(11))
    protocol = rig.loop.protocol
    wanted = MasterParams(rate_drop=20)
    protocol.hand_over(lambda: protocol.configure(master=wanted))
    rig.ticks(*range(11, 62))
    assert [first for first, *_ in rig.wires.blocks] == [0, 8, 16, 20, 40]
    assert [len(series["x"]) for *_, series in rig.wires.blocks] == [8, 8, 4, 20, 20]
    periods = [round(packet.period * 1e3) for packet in rig.wires.sent]
    assert periods == [8, 8, 8, 4, 20, 20]  # of the frame that ends


@pytest.mark.parametrize("rate_drop", [1, 2, 8, 20])
def test_one_packet_and_one_trace_block_leave_per_frame(rate_drop):
    rig = Rig(rate_drop=rate_drop)
    rig.ticks(*range(10 * rate_drop + 1))
    rig.loop.leave()
    assert [packet.seq for packet in rig.wires.sent] == list(range(1, 13))
    assert [first for first, *_ in rig.wires.blocks] == [rate_drop * i for i in range(11)]
    assert [len(series["x"]) for *_, series in rig.wires.blocks] == [rate_drop] * 10 + [1]
    assert rig.wires.motions in (10, 11)


def moving(rig):
    """33 ticks, in which the device moves and the server answers."""
    for grid in range(33):
        if grid % TICKS == 2:
            rig.answer(0.3)
        rig.device.sample.x += 1e-4 * math.sin(grid)
        rig.tick(grid)
    rig.loop.leave()
    assert len(rig.wires.blocks) == 5
    return [series for _, _, series in rig.wires.blocks]


def test_the_energies_of_a_block_are_those_at_its_end():
    rig = Rig()
    sums = {"u_m": 0.0, "v_m": 0.0}
    for series, energy in zip(moving(rig), rig.wires.energies, strict=True):
        for name in sums:
            sums[name] += sum(wave**2 for wave in series[name]) * 0.001 / 2
        assert {name: energy[name] for name in sums} == pytest.approx(sums)
    assert min(sums.values()) > 0.0


def test_the_work_of_a_block_is_force_times_distance_to_the_next_tick():
    rig = Rig()
    blocks = moving(rig)
    x = [value for series in blocks for value in series["x"]]
    for name, force in (("device", "f_applied"), ("hand", "f_h")):
        forces = [value for series in blocks for value in series[force]]
        work = [f * (x[k + 1] - x[k]) for k, f in enumerate(forces[:-1])]
        for number, energy in enumerate(rig.wires.energies):
            assert energy[name] == pytest.approx(sum(work[: (number + 1) * TICKS]))
        assert abs(sum(work)) > 1e-6


def test_a_device_that_knows_its_true_motion_counts_the_work():
    rig = Rig()
    rig.device.sample.work = (1.5, 2.5)
    moving(rig)
    assert [(e["device"], e["hand"]) for e in rig.wires.energies] == [(1.5, 2.5)] * 5


def test_a_skipped_tick_splits_the_block_and_shows_in_the_numbers():
    rig = Rig()
    rig.ticks(0, 1, 2)
    rig.tick(5, skipped=2)
    rig.ticks(6, 7, *range(8, 18))
    assert [(first, len(series["x"])) for first, _, series in rig.wires.blocks] == [
        (0, 3),
        (5, 3),
        (8, 8),
    ]
    assert rig.loop.missed == 2


def test_a_skipped_frame_start_is_made_up_for_at_once():
    rig = Rig()
    rig.ticks(*range(6))
    rig.tick(11, skipped=5)
    rig.ticks(*range(12, 17))
    assert [packet.seq for packet in rig.wires.sent] == [1, 2, 3]
    assert [first for first, *_ in rig.wires.blocks] == [0]


def test_there_is_no_force_before_the_server_has_answered():
    rig = Rig()
    rig.ticks(*range(40))
    assert set(rig.device.forces) == {0.0}
    assert rig.device.couplings == 0
    rig.answer()
    rig.ticks(*range(40, 60))
    assert rig.device.forces[-1] > 0.0


def test_the_hand_begins_once_when_the_force_is_there():
    rig = Rig()
    rig.ticks(*range(40))
    for grid in range(40, 1200):
        rig.answer()
        rig.tick(grid)
        full = rig.loop.protocol.state == SafetyState.COUPLED
        assert rig.device.couplings <= full
    assert rig.device.couplings == 1


def v_m_of(rig):
    return port_signals(rig.loop.protocol.s.port)[2][0]


def test_an_answer_counts_from_the_fourth_tick_of_its_frame():
    rig = Rig()
    rig.answer()
    rig.ticks(*range(8, 16))
    rig.answer(0.5)
    v_m = []
    for grid in range(16, 24):
        rig.tick(grid)
        v_m.append(v_m_of(rig))
    assert v_m[:4] == [0.0] * 4
    assert v_m[4] != 0.0


def test_an_answer_after_the_fourth_tick_waits_for_the_next_frame():
    rig = Rig()
    rig.answer()
    rig.ticks(*range(8, 21))
    rig.answer(0.5)
    rig.ticks(21, 22, 23)
    assert v_m_of(rig) == 0.0
    rig.ticks(24, 25, 26, 27, 28)
    assert v_m_of(rig) != 0.0


def test_a_change_from_another_thread_waits_for_the_frame_start():
    rig = Rig()
    rig.ticks(*range(3))
    seen = []
    rig.loop.protocol.hand_over(lambda: seen.append(rig.now_ns))
    rig.ticks(*range(3, 10))
    assert seen == [8 * TICK_NS]


def test_leaving_sets_the_device_to_zero_and_sends_a_last_packet_with_the_last_ticks():
    rig = Rig()
    rig.ticks(*range(11))
    rig.loop.leave()
    assert rig.device.stops == 1
    assert rig.wires.sent[-1].flags & FLAG_LEAVING
    assert not any(packet.flags & FLAG_LEAVING for packet in rig.wires.sent[:-1])
    assert sum(len(series["x"]) for *_, series in rig.wires.blocks) == 11


def test_a_failing_device_is_set_to_zero_and_the_server_gets_a_last_packet(monkeypatch):
    rig = Rig()
    rig.device.error = DeviceError("unplugged")
    monkeypatch.setattr(pacing, "request_real_time", lambda _: pacing.RealTimeReport())
    with pytest.raises(DeviceError, match="unplugged"):
        rig.loop.run(threading.Event())
    assert rig.device.stops == 1
    assert rig.wires.sent[-1].flags & FLAG_LEAVING


@pytest.mark.parametrize("pacing", ["host", "exchange", "device", "event"])
def test_a_silent_device_gets_no_force_and_is_reported_until_it_sends_again(pacing):
    rig = Rig(pacing=pacing)
    answered = iter(range(10**6))

    def tick_with_answers(*grids):
        for grid in grids:
            if next(answered) % TICKS == 2:
                rig.answer(-0.05)
            rig.tick(grid)

    tick_with_answers(*range(8, 800))
    end = rig.loop.protocol
    assert rig.device.forces[-1] > 0.5 and (end.state, end.s.limits.events) == (1, 0)
    rig.device.sample.fresh = False
    tick_with_answers(*range(800, 820))
    assert rig.device.forces[-1] > 0.5  # 20 ms without anything new: not silent yet
    tick_with_answers(*range(820, 840))
    assert rig.device.forces[-1] == 0.0
    assert (end.state, end.reason) == (SafetyState.DAMPING, "device silent: no force")
    tick_with_answers(*range(840, 1900))
    assert end.state == SafetyState.FAULT and "more than 1 s" in end.reason
    assert set(rig.device.forces[850:]) == {0.0} and end.s.limits.events == 1
    rig.device.sample.fresh = True
    tick_with_answers(*range(1900, 1910))
    assert end.state == SafetyState.STARTING
    assert 0.0 < rig.device.forces[-1] < 0.1
    tick_with_answers(*range(1910, 2500))
    assert end.state == SafetyState.COUPLED and rig.device.forces[-1] > 0.5


def test_a_device_that_never_spoke_is_a_fault_after_a_second():
    rig = Rig(pacing="event")
    rig.device.sample.valid = rig.device.sample.fresh = False
    for grid in range(8, 1200):
        rig.answer(-0.05)
        rig.tick(grid)
        if grid == 900:
            assert rig.loop.protocol.state == SafetyState.STARTING
    assert set(rig.device.forces) == {0.0}
    assert rig.loop.protocol.state == SafetyState.FAULT


@pytest.mark.parametrize(
    ("age_ms", "late", "force"), [(0, 0, True), (5, 0, True), (6, 792, True), (20, 792, True),
                                  (21, 792, False), (-1, 792, False)],
)  # fmt: skip
def test_the_age_of_a_sample_is_the_time_since_it_was_measured(age_ms, late, force):
    """Old ones are counted from 5 ms on, none from 20 ms on; one of the future is of another
    clock, and of no known age.
    """
    rig = Rig()
    for grid in range(8, 800):
        rig.answer(-0.05)
        rig.device.sample.measured_ns = (grid - age_ms) * TICK_NS
        rig.tick(grid)
    assert rig.loop.protocol.s.late == late
    assert (rig.device.forces[-1] > 0.5) == force and any(rig.device.forces) == force


@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_a_position_that_is_no_number_at_a_frame_start_is_forgotten_with_it(channel):
    rig = Rig(channel=channel)
    for grid in range(8, 800):
        rig.answer(-0.05)
        rig.device.sample.x = float("nan") if grid == 400 else 0.1
        rig.tick(grid)
    assert rig.device.forces[-1] > 0.1
    assert all(math.isfinite(p.wave) and math.isfinite(p.position) for p in rig.wires.sent)


def test_a_device_that_senses_nothing_is_given_no_force():
    rig = Rig()
    rig.answer(-0.05)
    rig.ticks(*range(8, 40))
    assert rig.device.forces[-1] != 0.0
    rig.device.sample.valid = False
    rig.device.sample.xd = float("nan")
    for grid in range(40, 64):
        rig.answer(-0.05)
        rig.tick(grid)
    assert rig.device.forces[-1] == 0.0
    rig.device.sample.valid = True
    rig.device.sample.xd = 0.02
    before = 0.0
    for grid in range(64, 600):
        rig.answer(-0.05)
        rig.tick(grid)
        force = rig.device.forces[-1]
        assert abs(force - before) <= SafetyParams().max_slew * 0.001 + 1e-9
        before = force
    assert before == pytest.approx(25.0 * 0.02 + math.sqrt(50.0) * 0.05, rel=1e-2)


def test_behind_another_server_the_force_starts_from_zero_even_after_a_stall_of_the_loop():
    rig = Rig()
    for grid in range(8, 1200):
        if grid % TICKS == 2:
            rig.answer(-0.05)
        rig.tick(grid)
    assert rig.device.forces[-1] > 0.5
    rig.server = Packer(1234, period=FRAME_S)  # it was started while this loop did not run
    for _ in range(3):
        rig.answer(-0.3)
    rig.device.forces.clear()
    rig.tick(1399, skipped=199)
    for grid in range(1400, 1800):
        if grid % TICKS == 2:
            rig.answer(-0.3)
        rig.tick(grid)
    assert rig.loop.protocol.inbox.epoch == 1234
    wanted = 25.0 * 0.02 + math.sqrt(50.0) * 0.3
    share = [force / wanted for force in rig.device.forces]
    assert max(share[5:23]) < 0.05  # 0.5 s of soft start, once the server has echoed a packet
    assert 0.7 < share[-1] < 0.85


def test_a_running_loop_keeps_no_memory():
    rig = Rig()
    rig.wires.send = lambda packet: None
    rig.wires.publish_trace = lambda block, loop: None
    rig.answer()
    rig.ticks(*range(1000))
    before = sys.getallocatedblocks()
    rig.ticks(*range(1000, 2000))
    rig.device.forces.clear()
    assert sys.getallocatedblocks() - before < 50
