# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Explicit state: an end that is set back to a snapshot goes on bit for bit as it did before.

Random controllers, filters, holds, port filters, couplings, contacts, axes and batches run with
packets lost and repeated, and with silences. Snapshots are also set into ends that were just made.
The control is a walk through everything that the ends hold: whatever a tick changes has to be
declared.
"""

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmwvc_core.frame.assembly import force_loop_of, server_step_of
from pmwvc_core.frame.device_sample import DeviceSample
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.plant.forces import Setting
from pmwvc_core.plant.operators import make_operator
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.state import Stateful, attributes
from pmwvc_core.wave.impedance import MatrixImpedance
from pmwvc_core.wave.ledger import EnergyLedger
from pmwvc_core.wave.rates import Hold

FILTERS = [
    {"kind": "none"},
    {"kind": "first_order", "pole_rad_s": 50.0},
    {"kind": "butterworth", "pass_hz": 20.0, "stop_hz": 60.0},
    {"kind": "integrate_and_dump"},
]
AROUND = [
    {},
    {"velocity_filter": {"kind": "exact", "cutoff_hz": 30.0}},
    {"velocity_filter": {"kind": "complementary", "cutoff_hz": 30.0}},
    {"velocity_filter": {"kind": "equivalent", "cutoff_hz": 30.0}},
    {"bank": {"kind": "dissertation"}, "local_model": {"damping": 2.0}},
    {"bank": {"kind": "complementary"}, "local_model": {"acts": "above", "stiffness": 50.0}},
    {"position": {"feedback": "printed", "gain": 2.0}},
    {"position": {"feedback": "budgeted", "gain": 2.0, "storage_j": 0.02}},
    {"position": {"feedback": "integral", "gain": 2.0, "adapts": True}},
]
SERVERS = [
    *({"coupling": name} for name in ("implicit", "one_step_delay", "one_frame_late")),
    {"coupling": "unwrapped", "integrator": "trapezoid"},
    *(
        {"coupling": "unknown", "environment": environment, "decoding": decoding}
        | {"compensation": compensation}
        for environment, decoding, compensation in (
            ("cube", "secant", "ledger"),
            ("wall", "late", "corrected"),
            ("wall_with_slope", "late", "printed"),
            ("hunt_crossley", "late", "none"),
            ("active_wall", "secant", "ledger"),
        )
    ),
]
DEVICES = [{}, {"velocity": "euler", "encoder_step_m": 1e-5}, {"friction": 0.2}]
HANDS = ["hand", "sinusoid", "constant"]


@st.composite
def scenarios(draw):
    """Draw one scenario, or two of a batch."""
    controller = draw(st.sampled_from(["pmwvc", "direct", "virtual_coupling", "tdpa", "pspm"]))
    server = dict(draw(st.sampled_from(SERVERS if controller == "pmwvc" else [{}])))
    dof = draw(st.sampled_from([1, 2]))
    contact = draw(st.sampled_from(["grip", "bilateral"]))
    master = {
        "filter": draw(st.sampled_from(FILTERS)),
        "hold": draw(st.sampled_from(["zoh", "foh"])),
        "rate_drop": draw(st.sampled_from([1, 4, 8])),
        **draw(st.sampled_from(AROUND)),
    }
    if dof == 2 and controller == "pmwvc" and draw(st.booleans()):
        master["impedance_matrix"] = "30 5; 5 20"
    said = {
        "name": "drawn",
        "duration_s": 1.0,
        "controller": controller,
        "users": 2,
        "dof": dof,
        "channel": "plain",
        "master": master,
        "device": draw(st.sampled_from(DEVICES)),
        "operator": {"kind": draw(st.sampled_from(HANDS))},
        "server": {**server, "contact": contact, "period_s": draw(st.sampled_from([4e-3, 8e-3]))},
        "safety": {"soft_start_s": 0.05, "timeout_s": 0.05},
        "task": {"kind": "carry", "grip_s": 0.05, "move_s": 0.2},
    }
    if master.get("position", {}).get("feedback") != "printed":
        said["channel"] = draw(st.sampled_from(["plain", "strict", "zeroing"]))
        if said["channel"] == "zeroing":
            master["rate_drop"] = round(said["server"]["period_s"] / 1e-3)
    return parse_scenario(said)


class Ends:
    """Both ends of a session: every block that runs, and packets that come at once or never."""

    def __init__(self, scenario, seed):
        self.seed = seed
        tick_s, dof = scenario.tick_s, scenario.dof
        self.tick_ns, self.period = round(tick_s * 1e9), scenario.period_ticks
        half = scenario.server.object_size_m / 2
        self.loops = [force_loop_of(scenario, i) for i in range(len(scenario.users))]
        self.server = server_step_of(scenario)
        self.devices, self.hands = [], []
        for user in scenario.users:
            start = user.side * (half + user.contact.gap_m)
            device = SimulatedDevice(user.device, tick_s=tick_s, dof=dof)
            device.place(start)
            self.devices.append(device)
            at = Setting(user.side, half, start, tick_s, dof)
            self.hands.append(make_operator(user.operator, scenario.task, at))
        self.blocks = [*self.loops, *self.devices, *self.hands, self.server]

    def run(self, ticks):
        """Go through the ticks; return everything that comes out, as bytes."""
        found = []
        for tick in ticks:
            now_ns = tick * self.tick_ns
            rng = np.random.default_rng([self.seed, tick])
            dead = np.random.default_rng([self.seed, tick // 100]).random() < 0.3
            odds = [1.0, 0.0, 0.0] if dead else [0.1, 0.8, 0.1]  # none, one or two arrive
            samples = [DeviceSample(*device.read()) for device in self.devices]
            for i, (loop, sample) in enumerate(zip(self.loops, samples, strict=True)):
                packet = loop.start_frame(tick, now_ns, sample)
                if packet is not None:
                    found += [packet.wave, packet.energy, packet.position]
                    for _ in range(rng.choice([0, 1, 2], p=odds)):
                        self.server.deliver(i, packet, now_ns)
            if tick % self.period == 0:
                answers, row = self.server.tick(now_ns, [[] for _ in self.loops])
                found += [row.dissipated, row.target]
                for loop, answer in zip(self.loops, answers, strict=True):
                    if answer is not None:
                        found += [answer.wave, answer.energy, answer.position]
                        for _ in range(rng.choice([0, 1, 2], p=odds)):
                            loop.inbox.push(answer, now_ns)
            for loop, device, hand, sample in zip(
                self.loops, self.devices, self.hands, samples, strict=True
            ):
                f_h = hand.step(device.x, device.xd) if loop.ready else hand.hold()
                force, _, _ = loop.tick(tick, now_ns, sample, [])
                found += [*device.step(f_h, force), force, f_h, loop.safety.state]
        return b"".join(np.asarray(value, dtype=float).tobytes() for value in found)


@settings(max_examples=40)
@given(scenarios(), st.integers(0, 2**16), st.integers(60, 160))
def test_ends_set_back_to_a_snapshot_go_on_bit_for_bit(drawn, seed, until):
    ends = Ends(drawn, seed)
    ends.run(range(until))
    states = [block.snapshot() for block in ends.blocks]
    expected = ends.run(range(until, until + 60))
    for others in (ends, Ends(drawn, seed)):  # itself, and one that was just made
        if others is not ends:
            others.run([0])  # everybody joins, so that the parts made by a first packet are there
        for block, state in zip(others.blocks, states, strict=True):
            block.restore(state)
        assert others.run(range(until, until + 60)) == expected


@settings(max_examples=40)
@given(scenarios(), st.integers(0, 2**16))
def test_whatever_a_tick_changes_is_declared(drawn, seed):
    ends = Ends(drawn, seed)
    ends.run(range(40))
    before = {place: copy.deepcopy(value) for place, value in held(ends.blocks)}
    ends.run(range(40, 140))
    declared = {(id(owner), name) for block in ends.blocks for _, owner, name in attributes(block)}
    for (owner, name, kind), value in held(ends.blocks):
        name = {"_sections": "delays"}.get(name, name)  # which reads and sets part of it
        known = before.get((owner, name, kind))
        assert (owner, name) in declared or same(known, value), f"{kind}.{name}"


def held(blocks):
    """Every attribute of all blocks but those that hold blocks: owner, name and value."""
    waiting, met = list(blocks), set()
    while waiting:
        block = waiting.pop()
        if id(block) in met:
            continue
        met.add(id(block))
        for name, value in contents(block).items():
            inside = list(value) if isinstance(value, (list, tuple)) else [value]
            blocks_inside = [each for each in inside if isinstance(each, Stateful)]
            waiting += blocks_inside
            if not blocks_inside and not callable(value):
                yield (id(block), name, type(block).__name__), value


def contents(block):
    """The attributes of an object by name, in slots or not."""
    slots = [name for base in type(block).__mro__ for name in getattr(base, "__slots__", ())]
    return {name: getattr(block, name) for name in [*slots, *getattr(block, "__dict__", ())]}


def same(left, right):
    """Whether two attributes are equal; objects of the program are, if what they hold is."""
    if isinstance(left, MatrixImpedance):  # which keeps the roots it was asked for
        return same(left.matrix, right.matrix)
    if type(left).__module__.startswith("pmwvc") and type(left) is type(right):
        return left is right or same(contents(left), contents(right))
    if isinstance(left, dict) and isinstance(right, dict):
        return left.keys() == right.keys() and all(same(left[k], right[k]) for k in left)
    if isinstance(left, (list, tuple)) and isinstance(right, (list, tuple)):
        return len(left) == len(right) and all(map(same, left, right))
    return bool(np.all(left == right)) or left is right


def test_a_snapshot_of_another_block_is_refused():
    hold, ledger = Hold("zoh", ticks=4), EnergyLedger()
    words = "Hold: the state of another block; in one of both only: done, energy_j, start"
    with pytest.raises(ValueError, match=words):
        hold.restore(ledger.snapshot())


def test_signals_are_read_and_set_by_their_names():
    hold = Hold("foh", ticks=2)
    hold.load(3.0)
    assert hold.signals() == {"start": 0.0, "target": 3.0, "value": 0.0}
    hold.set_signals({"start": 1.0})
    assert hold.step() == 2.0
