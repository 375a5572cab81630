# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The schedule of the force loop on an invented grid: no clock, no ROS."""

import gc
import math
import sys
import threading
from itertools import pairwise

import pytest
from support.loop_rig import TICK_NS, TICKS, Rig

from pmwvc_core.errors import DeviceError
from pmwvc_core.law.port.master import port_signals
from pmwvc_core.master.safety import SafetyState
from pmwvc_core.params import MasterParams, SafetyParams
from pmwvc_core.runtime import pacing
from pmwvc_core.transport.packet import FLAG_LEAVING


def answered(rig, grids, wave=-0.05, every=TICKS):
    """Run ticks of which every eighth has an answer of the server."""
    for grid in grids:
        if grid % every == 2 % every:
            rig.answer(wave)
        rig.tick(grid)
    return rig


def blocks_of(rig):
    return [(first, len(series["x"])) for first, _, series in rig.wires.blocks]


@pytest.mark.parametrize("rate_drop", [1, 8, 20])
def test_one_packet_and_one_trace_block_leave_per_frame_from_a_whole_frame_on(rate_drop):
    rig = Rig(rate_drop=rate_drop)
    if rate_drop > 1:
        rig.ticks(*range(3, rate_drop))
        assert not rig.wires.sent and not rig.device.forces
    rig.ticks(*range(rate_drop, 11 * rate_drop + 1))
    rig.loop.leave()
    assert [packet.seq for packet in rig.wires.sent] == list(range(1, 13))
    blocks = [(rate_drop * i, rate_drop) for i in range(10)]  # from the first whole frame on
    assert blocks_of(rig) == [*blocks, (10 * rate_drop, 1)]  # none of the last ticks is left out
    assert [bool(packet.flags & FLAG_LEAVING) for packet in rig.wires.sent] == [False] * 11 + [
        True
    ]
    assert rig.device.stops == 1


def test_changes_wait_for_the_frame_start_and_another_rate_lies_on_its_own_grid():
    rig, seen = Rig(rate_drop=8), []
    rig.ticks(*range(11))
    protocol = rig.loop.protocol
    protocol.hand_over(lambda: protocol.configure(master=MasterParams(rate_drop=20)))
    protocol.hand_over(lambda: seen.append(rig.now_ns))
    rig.ticks(*range(11, 62))
    assert seen == [16 * TICK_NS]
    assert blocks_of(rig) == [(0, 8), (8, 8), (16, 4), (20, 20), (40, 20)]
    periods = [round(packet.period * 1e3) for packet in rig.wires.sent]
    assert periods == [8, 8, 8, 4, 20, 20]  # of the frame that ends


@pytest.mark.parametrize("work", [None, (1.5, 2.5)])
def test_the_energies_of_a_block_are_those_at_its_end(work):
    """Of waves, and the work: force times distance to the next tick, or what a device that knows
    its true motion has counted.
    """
    rig = Rig()
    rig.device.sample.work = work
    for grid in range(33):
        if grid % TICKS == 2:
            rig.answer(0.3)
        rig.device.sample.x += 1e-4 * math.sin(grid)
        rig.tick(grid)
    rig.loop.leave()
    every = {
        name: [value for _, _, series in rig.wires.blocks for value in series[name]]
        for name in ("u_m", "v_m", "x", "f_applied", "f_h")
    }
    steps = [after - before for before, after in pairwise(every["x"])]
    for number, energy in enumerate(rig.wires.energies):
        end = (number + 1) * TICKS
        for name in ("u_m", "v_m"):
            assert energy[name] == pytest.approx(sum(w**2 for w in every[name][:end]) * 5e-4)
        for place, (name, force) in enumerate((("device", "f_applied"), ("hand", "f_h"))):
            done = [f * dx for f, dx in zip(every[force], steps, strict=False)]
            wanted = sum(done[:end]) if work is None else work[place]
            assert energy[name] == pytest.approx(wanted)
    assert min(energy["u_m"], energy["v_m"], abs(energy["device"]), abs(energy["hand"])) > 1e-6


def test_a_skipped_tick_splits_the_block_and_a_skipped_frame_start_is_made_up_for_at_once():
    rig = Rig()
    rig.ticks(0, 1, 2)
    rig.tick(5, skipped=2)
    rig.ticks(6, 7, *range(8, 18))
    assert blocks_of(rig) == [(0, 3), (5, 3), (8, 8)]
    assert rig.loop.missed == 2
    assert rig.wires.missed == [0, 2, 2]  # each before its first tick
    rig.tick(27, skipped=9)
    assert [packet.seq for packet in rig.wires.sent] == [1, 2, 3, 4]


def test_there_is_no_force_before_the_server_has_answered_and_the_hand_begins_once():
    rig = Rig()
    rig.ticks(*range(40))
    assert set(rig.device.forces) == {0.0}
    for grid in range(40, 1200):
        rig.answer()
        rig.tick(grid)
        full = rig.loop.protocol.state == SafetyState.COUPLED
        assert rig.device.couplings <= full
    assert rig.device.forces[-1] > 0.0
    assert rig.device.couplings == 1


@pytest.mark.parametrize(("came", "counts"), [(16, 20), (21, 28)])
def test_an_answer_counts_from_the_fourth_tick_of_its_frame_or_of_the_next(came, counts):
    rig, found = Rig(), []
    rig.answer()
    rig.ticks(*range(8, came))
    rig.answer(0.5)
    for grid in range(came, 30):
        rig.tick(grid)
        found.append(port_signals(rig.loop.protocol.s.port)[2][0])
    assert found[: counts - came] == [0.0] * (counts - came)
    assert found[counts - came] != 0.0


def test_a_failing_device_is_set_to_zero_and_the_server_gets_a_last_packet(monkeypatch):
    rig = Rig()
    rig.device.error = DeviceError("unplugged")
    monkeypatch.setattr(pacing, "request_real_time", lambda _: pacing.Granted())
    with pytest.raises(DeviceError, match="unplugged"):
        rig.loop.run(threading.Event())
    assert rig.device.stops == 1
    assert rig.wires.sent[-1].flags & FLAG_LEAVING


def test_a_silent_device_gets_no_force_and_is_reported_and_after_a_second_a_fault():
    """Until it is re-armed: ``oracle/test_silent_device.py``."""
    rig = answered(Rig(), range(8, 800))
    end, forces = rig.loop.protocol, rig.device.forces
    assert forces[-1] > 0.5 and (end.state, end.s.limits.events) == (1, 0)
    rig.device.sample.fresh = False
    answered(rig, range(800, 820))
    assert forces[-1] > 0.5  # 20 ms without anything new: not silent yet
    answered(rig, range(820, 840))
    assert forces[-1] == 0.0
    assert (end.state, end.reason) == (SafetyState.DAMPING, "device silent: no force")
    answered(rig, range(840, 1900))
    assert end.state == SafetyState.FAULT and "more than 1 s" in end.reason
    assert set(forces[850:]) == {0.0} and end.s.limits.events == 1


def test_a_device_that_never_spoke_is_a_fault_after_a_second():
    rig = Rig()
    rig.device.sample.valid = rig.device.sample.fresh = False
    answered(rig, range(8, 901))
    assert rig.loop.protocol.state == SafetyState.STARTING
    answered(rig, range(901, 1200))
    assert set(rig.device.forces) == {0.0}
    assert rig.loop.protocol.state == SafetyState.FAULT


@pytest.mark.parametrize(
    ("age_ms", "late", "force"), [(5, 0, True), (6, 792, True), (20, 792, True), (21, 792, False),
                                  (-1, 792, False)],
)  # fmt: skip
def test_the_age_of_a_sample_is_the_time_since_it_was_measured(age_ms, late, force):
    """Old ones are counted from 5 ms on, none from 20 ms on; one of the future is of another
    clock, and of no known age.
    """
    rig = Rig()
    for grid in range(8, 800):
        rig.device.sample.measured_ns = (grid - age_ms) * TICK_NS
        answered(rig, [grid])
    assert rig.loop.protocol.s.late == late
    assert (rig.device.forces[-1] > 0.5) == force and any(rig.device.forces) == force


@pytest.mark.parametrize("channel", ["plain", "strict"])
def test_a_position_that_is_no_number_at_a_frame_start_is_forgotten_with_it(channel):
    rig = Rig(channel=channel)
    for grid in range(8, 800):
        rig.device.sample.x = float("nan") if grid == 400 else 0.1
        answered(rig, [grid])
    assert rig.device.forces[-1] > 0.1
    assert all(math.isfinite(p.wave) and math.isfinite(p.position) for p in rig.wires.sent)


def test_a_device_that_senses_nothing_is_given_no_force_and_then_one_without_a_step():
    rig = answered(Rig(), range(8, 40), every=1)
    assert rig.device.forces[-1] != 0.0
    rig.device.sample.valid, rig.device.sample.xd = False, float("nan")
    answered(rig, range(40, 64), every=1)
    assert rig.device.forces[-1] == 0.0
    rig.device.sample.valid, rig.device.sample.xd = True, 0.02
    rig.device.forces.clear()
    forces = [0.0, *answered(rig, range(64, 600), every=1).device.forces]
    steps = [abs(b - a) for a, b in pairwise(forces)]
    assert max(steps) <= SafetyParams().max_slew * 0.001 + 1e-9
    assert forces[-1] == pytest.approx(25.0 * 0.02 + math.sqrt(50.0) * 0.05, rel=1e-2)


@pytest.mark.parametrize("stood", [5, 30, 299])
def test_a_loop_that_stood_still_comes_back_without_a_step(stood):
    """What it rendered goes over into the new force in 20 ms; the control: after 5 ms the
    force is the new one at once, within the slew limit.
    """
    rig = answered(Rig(), range(8, 1200), wave=-0.3)
    before = rig.device.forces[-1]
    rig.device.forces.clear()
    rig.device.sample.xd = -0.05
    rig.tick(1200 + stood, skipped=stood)
    answered(rig, range(1201 + stood, 1700), wave=-0.3)
    steps = [abs(b - a) for a, b in pairwise([before, *rig.device.forces])]
    assert (max(steps) < 2.0 * before / 20.0) is (stood > 20)
    assert rig.device.forces[-1] == pytest.approx(-25.0 * 0.05 + math.sqrt(50.0) * 0.3, rel=1e-2)
    back = next(k for k, f in enumerate(rig.device.forces) if k > 20 and f > 0.5)
    assert back < 150


def test_a_running_loop_keeps_no_memory():
    rig = Rig()
    rig.wires.send = lambda packet: None
    rig.wires.publish_trace = lambda block, loop: None
    rig.answer()
    rig.ticks(*range(1000))
    rig.device.forces.clear()
    gc.collect()  # which empties Python's free lists: blocks in them are none that is kept
    before = sys.getallocatedblocks()
    rig.ticks(*range(1000, 2000))
    rig.device.forces.clear()
    gc.collect()
    assert sys.getallocatedblocks() - before < 50
