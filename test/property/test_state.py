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

from pmwvc_core.controllers import has_waves, make_master, make_server
from pmwvc_core.master.client import Client
from pmwvc_core.master.safety import SafetyLimiter
from pmwvc_core.plant.devices import SimulatedDevice
from pmwvc_core.plant.operators import make_operator
from pmwvc_core.plant.task import ShownTarget, Task
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.server.service import Service
from pmwvc_core.simulation.stacking import stack
from pmwvc_core.state import Stateful, attributes
from pmwvc_core.transport.inboxes import inbox
from pmwvc_core.transport.packet import Packer
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
        "master": master,
        "device": draw(st.sampled_from(DEVICES)),
        "operator": {"kind": draw(st.sampled_from(HANDS))},
        "server": {**server, "contact": contact, "period_s": draw(st.sampled_from([4e-3, 8e-3]))},
        "safety": {"soft_start_s": 0.05, "timeout_s": 0.05},
        "task": {"kind": "carry", "grip_s": 0.05, "move_s": 0.2},
    }
    runs = draw(st.sampled_from([1, 2])) if "impedance_matrix" not in master else 1
    return [
        parse_scenario(said, overrides={"server.contact_stiffness": 100.0 + 50.0 * run})
        for run in range(runs)
    ]


class Ends:
    """Both ends of a session: every block that runs, and packets that come at once or never."""

    def __init__(self, scenarios, seed):
        first, self.seed = scenarios[0], seed
        self.tick_ns, self.period = round(first.tick_s * 1e9), first.period_ticks
        dof, waves = first.dof, has_waves(first.controller)
        users = [[scenario.users[i] for scenario in scenarios] for i in range(len(first.users))]
        server = stack([scenario.server for scenario in scenarios])
        half = server.object_size_m / 2
        self.drops = [user.master.rate_drop for user in first.users]
        self.clients, self.devices, self.hands, inboxes = [], [], [], []
        for i, same in enumerate(users):
            user, tick_s = same[0], first.tick_s
            master = stack([u.master for u in same])
            start = user.side * (half + user.contact.gap_m)
            if len(same) > 1:
                start = start + np.zeros((len(same), 1))
            ways = [
                inbox(dof, b, waves=waves, period_s=period_s, timeout_s=user.safety.timeout_s)
                for b, period_s in (
                    (user.impedance, server.period_s),
                    (user.server_impedance, user.master.frame_s),
                )
            ]
            self.clients.append(
                Client(
                    make_master(first.controller, master, user.baseline),
                    SafetyLimiter(user.safety, tick_s=tick_s, packet_s=server.period_s),
                    inbox=ways[0],
                    packer=Packer(i + 1, period=user.master.frame_s),
                )
            )
            inboxes.append(ways[1])
            device = SimulatedDevice(user.device, tick_s=tick_s, dof=dof)
            device.place(start)
            self.devices.append(device)
            self.hands.append(
                make_operator(
                    user.operator,
                    first.task,
                    side=user.side,
                    half_width=half,
                    tick_s=tick_s,
                    dof=dof,
                    start=start,
                )
            )
        self.service = Service(
            make_server(
                first.controller,
                server,
                [stack([u.contact for u in same]) for same in users],
                [same[0].server_impedance for same in users],
                dof=dof,
                sides=[user.side for user in first.users],
                baselines=[user.baseline for user in first.users],
            ),
            inboxes=inboxes,
            packers=[Packer(1000 + i, period=server.period_s) for i in range(len(users))],
        )
        self.target = ShownTarget(
            Task(first.task), period_s=server.period_s, soft_start_s=0.05, dof=dof
        )
        self.blocks = [*self.clients, *self.devices, *self.hands, self.service, self.target]

    def run(self, ticks):
        """Go through the ticks; return everything that comes out, as bytes."""
        found = []
        for tick in ticks:
            now_ns = tick * self.tick_ns
            rng = np.random.default_rng([self.seed, tick])
            dead = np.random.default_rng([self.seed, tick // 100]).random() < 0.3
            odds = [1.0, 0.0, 0.0] if dead else [0.1, 0.8, 0.1]  # none, one or two arrive
            for i, client in enumerate(self.clients):
                if tick % self.drops[i] == 0:
                    client.controller.measure(*self.devices[i].read())
                    packet = client.send(now_ns)
                    found += [packet.wave, packet.energy, packet.position]
                    for _ in range(rng.choice([0, 1, 2], p=odds)):
                        self.service.deliver(i, packet, now_ns)
            if tick % self.period == 0:
                for client, answer in zip(self.clients, self.service.step(now_ns), strict=True):
                    if answer is not None:
                        found += [answer.wave, answer.energy, answer.position]
                    for _ in range(rng.choice([0, 1, 2], p=odds)):
                        if answer is not None:
                            client.inbox.push(answer, now_ns)
                together = self.service.together()
                found += [self.service.server.dissipated, self.target.step(together=together)]
            for i, client in enumerate(self.clients):
                device, hand = self.devices[i], self.hands[i]
                if tick % self.drops[i] == 0:
                    client.receive(now_ns)
                f_h = hand.step(device.x, device.xd) if client.ready() else hand.hold()
                force = client.step(*device.read(), now_ns)
                found += [*device.step(f_h, force), force, f_h, client.safety.state]
        return b"".join(np.asarray(value, dtype=float).tobytes() for value in found)


@settings(max_examples=40)
@given(scenarios(), st.integers(0, 2**16), st.integers(60, 300))
def test_ends_set_back_to_a_snapshot_go_on_bit_for_bit(drawn, seed, until):
    ends = Ends(drawn, seed)
    ends.run(range(until))
    states = [block.snapshot() for block in ends.blocks]
    expected = ends.run(range(until, until + 100))
    for others in (ends, Ends(drawn, seed)):  # itself, and one that was just made
        if others is not ends:
            others.run([0])  # everybody joins, so that the parts made by a first packet are there
        for block, state in zip(others.blocks, states, strict=True):
            block.restore(state)
        assert others.run(range(until, until + 100)) == expected


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
