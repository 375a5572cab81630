# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The steps of the server and their users on an invented grid: no clock, no ROS."""

import itertools
from functools import partial

import pytest
from support.loop_rig import Wires
from support.packer import Packer
from support.session_given import session_given

from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.frame import Presence
from pmwvc_core.params import ContactParams, ServerParams, TaskParams
from pmwvc_core.params.user import ServerTimes
from pmwvc_core.plant.forces import offset, task_of
from pmwvc_core.runtime.pacing import Tick
from pmwvc_core.scenario.scenario import User
from pmwvc_core.transport.packet import FLAG_ANEW, FLAG_CHALLENGE, FLAG_LEAVING
from pmwvc_server.loop import ServerLoop

PERIOD_S = 0.008
PERIOD_NS = 8_000_000
SOFT_START_S = 0.16
TASK = TaskParams(kind="carry", move_s=0.0, move_rise_s=1.0, distance_m=0.05)
BOTH, FIRST = ["COUPLED", "COUPLED"], ["COUPLED", "ABSENT"]


class Rig:
    """Two users, a loop between fakes, and a clock that shows what the test says."""

    def __init__(self, **server):
        self.links, self.now_ns, self.grid, self.rows = (Wires(), Wires()), 0, 0, []
        self.sent = [link.sent for link in self.links]
        contact = ContactParams(contact="bilateral")
        users = [User(f"user{side}", side=side, contact=contact) for side in (-1, 1)]
        self.masters = [Packer(epoch, period=PERIOD_S) for epoch in (1, 2)]
        times = ServerTimes(timeout_s=0.03, release_s=1.0, soft_start_s=SOFT_START_S)
        session = session_given(users=users, server=ServerParams(**server), task=TASK, times=times)
        self.end = ServerEnd(session, epoch=9, idle_until_joined=True)
        self.loop = ServerLoop(
            self.end,
            links=self.links,
            publish_trace=lambda loop, step: self.rows.append(step.row),
            clock=lambda: self.now_ns,
        )

    def send(self, user, wave=0.0, *, flags=0):
        sent = self.sent[user]
        echo = (sent[-1].seq, sent[-1].sent_ns, 0) if sent else (0, 0, 0)
        packet = self.masters[user].pack(wave, user - 0.5, self.now_ns, flags=flags, echo=echo)
        self.links[user].arrived.append(packet)

    def step(self, *users, times=1, wave=0.0):
        """Let users send and the server step, ``times`` times."""
        for _ in range(times):
            self.grid += 1
            self.now_ns = self.grid * PERIOD_NS
            for user in users:
                self.send(user, wave)
            self.loop.tick(Tick(self.grid, self.now_ns, self.now_ns, 0, 0))
        return self

    @property
    def unaccounted_j(self):
        """What came in as waves and is neither stored nor lost."""
        row = self.rows[-1]
        held = row.kinetic + row.potential + row.dissipated
        return sum(row.energy_u_s) - sum(row.energy_v_s) - held

    def bye(self, user):
        self.send(user, flags=FLAG_LEAVING)

    @property
    def presence(self):
        return [presence.name for presence in self.end.presence]


def test_steps_begin_with_the_first_user_and_only_who_is_there_is_answered():
    """An avatar appears where the device is, without a force."""
    rig = Rig().step(times=5)
    assert rig.end.steps == 0 and not rig.rows
    rig.step(0, times=4)
    assert rig.presence == FIRST
    rig.step(0, 1, times=3)
    assert rig.end.steps == 7
    assert [len(sent) for sent in rig.sent] == [7, 3]
    assert [packet.seq for packet in rig.sent[0]] == list(range(1, 8))
    assert (rig.end.row().x_s, rig.end.row().f_s) == ((-0.5, 0.5), (0.0, 0.0))
    rig.bye(0)
    rig.step(1)
    coupled, absent = Presence.COUPLED, Presence.ABSENT
    states = [state for state, _ in itertools.groupby(row.state for row in rig.rows)]
    assert states == [(coupled, absent), (coupled, coupled), (absent, coupled)]


def test_the_next_master_of_a_user_who_has_left_is_challenged_and_joins_by_its_answer():
    rig = Rig().step(0, 1, times=10)
    played_back = rig.masters[1].pack(0.5, 0.5, rig.now_ns)
    rig.bye(1)
    rig.step(0)
    assert rig.presence == FIRST  # gone at once
    answered = len(rig.sent[1])
    rig.step(0, times=5)
    assert len(rig.sent[1]) == answered
    for _ in range(20):  # a ghost is challenged, too, and does not answer
        rig.links[1].arrived.append(played_back)
        rig.step(0)
    assert rig.presence == FIRST
    rig.masters[1] = Packer(77, period=PERIOD_S)
    rig.sent[1].clear()
    rig.step(0, 1)
    (challenge,) = rig.sent[1]
    assert challenge.flags & FLAG_CHALLENGE and challenge.wave == 0.0
    rig.step(0, 1)
    assert rig.presence == BOTH
    assert rig.end.row().f_s[1] == 0.0
    assert not rig.sent[1][-1].flags & FLAG_CHALLENGE


def test_a_silent_user_is_damped_then_gone_and_the_other_one_stays():
    """A master can tell a new avatar from the old one."""

    def anew(user):
        return {packet.flags & FLAG_ANEW for packet in rig.sent[user]}

    rig = Rig().step(0, 1, times=10, wave=0.3).step(0, times=10)
    assert rig.presence == ["COUPLED", "DAMPING"]
    assert rig.rows[-1].u_s[1] == 0.0 and rig.rows[-2].potential > 0.0
    rig.step(0, 1)  # a gap too short to be taken out
    assert len(anew(1)) == 1
    rig.step(0, times=130)
    assert rig.presence == FIRST
    rig.step(0, 1)
    assert rig.presence == BOTH and rig.unaccounted_j == pytest.approx(0.0, abs=1e-15)
    assert (len(anew(1)), len(anew(0))) == (2, 1)


def test_a_restarted_user_begins_anew_without_a_force():
    rig = Rig(environment="wall").step(0, 1, times=10).step(0, 1, times=5, wave=0.7)
    assert rig.end.row().f_s[1] != 0.0
    rig.masters[1] = Packer(77, period=PERIOD_S)
    rig.step(0, 1, times=2)  # the old life is not silent yet: nothing of the new one is used
    assert rig.end.row().f_s[1] != 0.0 and rig.sent[1][-1].echo_seq == 15
    rig.step(0, times=2).step(0, 1)
    assert rig.end.inboxes[1].epoch == 77
    assert (rig.end.row().x_s[1], rig.end.row().f_s[1]) == (0.5, 0.0)
    rig.step(0, 1, times=5, wave=0.7)
    rig.bye(1)
    rig.step(0)  # what its spring held was lost, twice
    assert rig.rows[-2].potential > 0.0 and rig.unaccounted_j == pytest.approx(0.0, abs=1e-13)


def test_the_target_rests_until_all_are_there():
    rig = Rig().step(0, times=200)
    assert rig.end.row().target == 0.0
    rig.step(0, 1, times=1 + round(0.5 / PERIOD_S))
    moving_s = round(0.5 / PERIOD_S) * PERIOD_S - SOFT_START_S
    (expected,) = offset(moving_s, task_of(TASK, 1))
    assert rig.end.row().target == pytest.approx(expected, rel=1e-9)
    assert expected > 0.0


def test_another_period_begins_with_the_next_step_and_lies_on_its_own_grid():
    rig = Rig().step(0, 1, times=3)
    changes = {42: 0.02, 82: 0.008, 98: 0.02}  # time of the step that takes it [ms], period [s]
    lasted = {}
    for due_ms in (42, 62, 82, 90, 98, 102, 122):
        rig.now_ns = due_ms * 1_000_000
        if due_ms in changes:
            wanted = ServerParams(period_s=changes[due_ms])
            rig.end.hand_over(partial(rig.loop.configure, wanted))
        rig.send(0)
        rig.loop.tick(Tick(0, rig.now_ns, rig.now_ns, 0, 0))
        lasted[due_ms] = round(rig.end.p.period_s * 1e3)
    # Only the step at 98 ms is shorter: 102 ms is on the grid of 20 ms, 2 ms behind its points.
    assert lasted == {42: 20, 62: 20, 82: 8, 90: 8, 98: 4, 102: 20, 122: 20}
    assert [round(p.period * 1e3) for p in rig.sent[0][-7:]] == list(lasted.values())
