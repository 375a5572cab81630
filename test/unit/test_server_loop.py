# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The steps of the server and their users on an invented grid: no clock, no ROS."""

from functools import partial

import pytest
from support.packer import Packer
from support.session_given import session_given

from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.frame.rows import Presence
from pmwvc_core.params import ContactParams, ServerParams, TaskParams
from pmwvc_core.params.user import ServerTimes
from pmwvc_core.plant.task import offset, task_of
from pmwvc_core.runtime.pacing import Tick
from pmwvc_core.scenario.scenario import User
from pmwvc_core.transport.packet import FLAG_ANEW, FLAG_CHALLENGE, FLAG_LEAVING
from pmwvc_server.loop import ServerLoop

PERIOD_S = 0.008
PERIOD_NS = 8_000_000
SOFT_START_S = 0.16
TASK = TaskParams(kind="carry", move_s=0.0, move_rise_s=1.0, distance_m=0.05)


class Link:
    """One end of a user's link: lists."""

    def __init__(self):
        self.arrived, self.sent = [], []
        self.send = self.sent.append

    def take(self):
        arrived = list(self.arrived)
        self.arrived.clear()
        return arrived


class Wires:
    """Wires that end in lists."""

    def __init__(self, users):
        self.links = [Link() for _ in range(users)]
        self.arrived = [link.arrived for link in self.links]
        self.sent = [link.sent for link in self.links]
        self.steps, self.rows = [], []

    def publish_trace(self, loop, step):
        self.rows.append(step.row)
        self.steps.append((loop.protocol.steps, list(step.row.state)))


class Rig:
    """Two users, a loop between fakes, and a clock that shows what the test says."""

    def __init__(self, **server):
        self.wires, self.now_ns, self.grid = Wires(2), 0, 0
        contact = ContactParams(contact="bilateral")
        users = [User(f"user{side}", side=side, contact=contact) for side in (-1, 1)]
        self.masters = [Packer(epoch, period=PERIOD_S) for epoch in (1, 2)]
        self.loop = ServerLoop(
            ServerEnd(
                session_given(
                    users=users,
                    server=ServerParams(**server),
                    task=TASK,
                    times=ServerTimes(timeout_s=0.03, release_s=1.0, soft_start_s=SOFT_START_S),
                ),
                epoch=9,
                idle_until_joined=True,
            ),
            links=self.wires.links,
            publish_trace=self.wires.publish_trace,
            clock=lambda: self.now_ns,
        )

    def send(self, user, wave=0.0, *, flags=0):
        sent = self.wires.sent[user]
        echo = (sent[-1].seq, sent[-1].sent_ns, 0) if sent else (0, 0, 0)
        packet = self.masters[user].pack(wave, user - 0.5, self.now_ns, flags=flags, echo=echo)
        self.wires.arrived[user].append(packet)

    def step(self, *users, times=1, wave=0.0):
        """Let users send and the server step, ``times`` times."""
        for _ in range(times):
            self.grid += 1
            self.now_ns = self.grid * PERIOD_NS
            for user in users:
                self.send(user, wave)
            self.loop.tick(Tick(self.grid, self.now_ns, self.now_ns, 0, 0))

    @property
    def presence(self):
        return [presence.name for presence in self.loop.protocol.presence]


def test_steps_begin_with_the_first_packet_of_any_user():
    rig = Rig()
    rig.step(times=5)
    assert rig.loop.protocol.steps == 0 and not rig.wires.steps
    rig.step(1)
    assert rig.loop.protocol.steps == 1
    assert rig.presence == ["ABSENT", "COUPLED"]
    rig.step(times=5)
    assert rig.loop.protocol.steps == 6


def test_only_users_who_are_there_are_answered():
    rig = Rig()
    rig.step(0, times=4)
    rig.step(0, 1, times=3)
    assert [len(sent) for sent in rig.wires.sent] == [7, 3]
    assert [packet.seq for packet in rig.wires.sent[0]] == list(range(1, 8))


def test_an_avatar_appears_where_the_device_is_without_a_force():
    rig = Rig()
    rig.step(0, 1)
    end = rig.loop.protocol
    assert [end.avatar(user) for user in (0, 1)] == [(-0.5, 0.0), (0.5, 0.0)]


def test_a_silent_user_is_damped_then_gone_and_the_other_one_stays():
    rig = Rig()
    rig.step(0, 1, times=10)
    rig.step(0, times=4)
    assert rig.presence == ["COUPLED", "DAMPING"]
    assert rig.wires.rows[-1].u_s[1] == 0.0
    rig.step(0, times=130)
    assert rig.presence == ["COUPLED", "ABSENT"]
    rig.step(0, 1)
    assert rig.presence == ["COUPLED", "COUPLED"]


def test_a_master_can_tell_a_new_avatar_from_the_old_one():
    rig = Rig()
    rig.step(0, 1, times=10)
    rig.step(0, times=10)  # a gap of 1's packets, too short to be taken out
    rig.step(0, 1)
    flags = {packet.flags & FLAG_ANEW for packet in rig.wires.sent[1]}
    assert len(flags) == 1
    rig.step(0, times=130)
    rig.step(0, 1)
    assert rig.wires.sent[1][-1].flags & FLAG_ANEW not in flags
    assert len({packet.flags & FLAG_ANEW for packet in rig.wires.sent[0]}) == 1


def test_a_user_who_sent_its_last_packet_is_gone_at_once():
    rig = Rig()
    rig.step(0, 1, times=10)
    rig.send(1, flags=FLAG_LEAVING)
    rig.step(0)
    assert rig.presence == ["COUPLED", "ABSENT"]
    answered = len(rig.wires.sent[1])
    rig.step(0, times=5)
    assert len(rig.wires.sent[1]) == answered


def test_the_next_master_of_a_user_who_has_left_is_challenged_and_joins_by_its_answer():
    rig = Rig()
    rig.step(0, 1, times=10)
    played_back = rig.masters[1].pack(0.5, 0.5, rig.now_ns)
    rig.send(1, flags=FLAG_LEAVING)
    rig.step(0)
    for _ in range(20):  # a ghost is challenged, too, and does not answer
        rig.wires.arrived[1].append(played_back)
        rig.step(0)
    assert rig.presence == ["COUPLED", "ABSENT"]
    rig.masters[1] = Packer(77, period=PERIOD_S)
    rig.wires.sent[1].clear()
    rig.step(0, 1)
    (challenge,) = rig.wires.sent[1]
    assert challenge.flags & FLAG_CHALLENGE and challenge.wave == 0.0
    rig.step(0, 1)
    assert rig.presence == ["COUPLED", "COUPLED"]
    assert rig.loop.protocol.avatar(1)[1] == 0.0
    assert not rig.wires.sent[1][-1].flags & FLAG_CHALLENGE


def test_a_restarted_user_begins_anew_without_a_force():
    rig = Rig(environment="wall")
    rig.step(0, 1, times=10)
    rig.step(0, 1, times=5, wave=0.7)
    end = rig.loop.protocol
    assert end.avatar(1)[1] != 0.0
    rig.masters[1] = Packer(77, period=PERIOD_S)
    rig.step(0, 1, times=2)  # the old life is not silent yet: nothing of the new one is used
    assert end.avatar(1)[1] != 0.0 and rig.wires.sent[1][-1].echo_seq == 15
    rig.step(0, times=2)
    rig.step(0, 1)
    assert end.inboxes[1].epoch == 77
    assert end.avatar(1) == (0.5, 0.0)


def test_joins_and_leaves_are_reported_in_order():
    rig = Rig()
    rig.step(0, times=2)
    rig.step(0, 1, times=2)
    rig.send(0, flags=FLAG_LEAVING)
    rig.step(1)
    assert list(rig.loop.changes) == [
        (0, Presence.COUPLED),
        (1, Presence.COUPLED),
        (0, Presence.ABSENT),
    ]


def test_the_target_rests_until_all_are_there():
    rig = Rig()
    rig.step(0, times=200)
    assert rig.loop.protocol.target_m == 0.0
    rig.step(0, 1, times=1 + round(0.5 / PERIOD_S))
    moving_s = round(0.5 / PERIOD_S) * PERIOD_S - SOFT_START_S
    (expected,) = offset(moving_s, task_of(TASK, 1))
    assert rig.loop.protocol.target_m == pytest.approx(expected, rel=1e-9)
    assert expected > 0.0


def test_a_pause_stands_still_without_energy_and_users_join_anew_after_it():
    rig = Rig()
    rig.step(0, 1, times=30, wave=0.1)
    protocol = rig.loop.protocol
    before, sent = rig.wires.rows[-1], [len(each) for each in rig.wires.sent]
    steps = protocol.steps
    assert before.potential > 0.0
    protocol.hand_over(lambda: protocol.pause(True))
    rig.step(0, 1, times=300, wave=0.1)
    assert (protocol.steps, protocol.x_o) == (steps, before.x_o)
    assert [len(each) for each in rig.wires.sent] == sent
    assert rig.presence == ["ABSENT", "ABSENT"]
    # What springs held became heat.
    held = before.potential + before.dissipated
    assert protocol.s.environment.dissipated_j == pytest.approx(held, rel=1e-12)
    protocol.hand_over(lambda: protocol.pause(False))
    rig.step(0, 1)
    assert rig.presence == ["COUPLED", "COUPLED"]
    assert [box.lost for box in protocol.inboxes] == [0, 0]


def test_another_period_begins_with_the_next_step_and_lies_on_its_own_grid():
    rig = Rig()
    rig.step(0, 1, times=3)
    changes = {42: 0.02, 82: 0.008, 98: 0.02}  # time of the step that takes it [ms], period [s]
    lasted = {}
    for due_ms in (42, 62, 82, 90, 98, 102, 122):
        rig.now_ns = due_ms * 1_000_000
        if due_ms in changes:
            wanted = ServerParams(period_s=changes[due_ms])
            rig.loop.protocol.hand_over(partial(rig.loop.configure, wanted))
        rig.send(0)
        rig.loop.tick(Tick(0, rig.now_ns, rig.now_ns, 0, 0))
        lasted[due_ms] = round(rig.loop.protocol.p.period_s * 1e3)
    # Only the step at 98 ms is shorter: 102 ms is on the grid of 20 ms, 2 ms behind its points.
    assert lasted == {42: 20, 62: 20, 82: 8, 90: 8, 98: 4, 102: 20, 122: 20}
    assert [round(p.period * 1e3) for p in rig.wires.links[0].sent[-7:]] == list(lasted.values())
