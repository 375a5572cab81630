# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A batch on the strict channel is its sessions one by one."""

import functools

import numpy as np

from pmwvc_bringup import scenarios
from pmwvc_core.simulation.batch import SessionBatch
from pmwvc_core.wave.playout import Playout

QUICK = ("channel=strict", "task.grip_s=0.1", "task.grip_rise_s=0.2")
TICK_S = 0.001
OUT_NS = range(500_000_000, 700_000_000)  # in which nothing passes up


def pair():
    """Two sessions whose ports differ: in what they repay, and in the longest wave they take."""
    return [
        scenarios.load(
            "carry_16ms", settings_texts=[*QUICK, f"master.impedance={b}"], duration_s=1.5
        )
        for b in (10.0, 50.0)
    ]


def ran(sessions):
    """Traces of sessions run together."""
    batch = SessionBatch(sessions)
    for user in batch.users:
        user.up.send = functools.partial(pass_on, user.up.send)
    batch.run(lambda _: None)
    return [batch.traces(run) for run in range(len(sessions))]


def pass_on(send, packet, now_ns):
    if now_ns not in OUT_NS:
        send(packet, now_ns)


def apart(one, other):
    return max(
        np.abs(a.f_applied - b.f_applied).max()
        for a, b in zip(one.users, other.users, strict=True)
    )


def test_a_batch_is_its_sessions_one_by_one():
    sessions = pair()
    for session, together in zip(sessions, ran(sessions), strict=True):
        assert apart(ran([session])[0], together) < 1e-9
    assert apart(*ran(sessions)) > 0.1  # they differ


def test_a_receiver_has_limits_of_each_run():
    for user in SessionBatch(pair()).users:
        for link in (user.up, user.down):
            inbox = link.receiver
            assert np.shape(inbox.max_wave) == np.shape(inbox.playout.most_repaid) == (2, 1)
            assert np.ptp(inbox.playout.most_repaid) > 0.0


def test_each_run_repays_by_its_own_limit():
    limits = np.array([[0.01], [0.05]])
    playout = Playout(most_repaid=limits)
    playout.add(np.zeros((2, 1)), np.full((2, 1), 0.01), 0.29)
    playout.take_back(np.ones((2, 1)), 1.0)
    waves = [playout.step(TICK_S) for _ in range(250)]  # after a while without a wait
    np.testing.assert_allclose(np.max(waves, axis=0), limits)
