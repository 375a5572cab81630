# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a replay is from its recording, and the recorded targets of remote hands that
drive it.
"""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from rclpy.serialization import serialize_message
from scipy.spatial.transform import Rotation
from std_msgs.msg import Bool
from support import plain as scenarios
from support.vendor_setup import vendor_setup

from pmwvc_analysis.recording import schemas
from pmwvc_analysis.recording.content import hand_targets, is_of_hand
from pmwvc_analysis.recording.salvage import RawMessage
from pmwvc_analysis.replay.recorded import remote_hand
from pmwvc_analysis.replay.run import replay
from pmwvc_bringup.commands.compare import lead
from pmwvc_core.ends.user_end import CATCH_UP_S, DevicePlant
from pmwvc_core.errors import RecordingError
from pmwvc_core.params import ServerParams
from pmwvc_core.simulation.session import simulate_one
from pmwvc_core.traces import HandTargets
from pmwvc_master.devices.simulated import SimulatedDevice


def user(force, first=None, **others):
    found = {
        "name": "user1",
        "ticks": 900,
        "missing": 0,
        "force_max_n": force,
        "position_max_m": force,
    }
    found |= {"first_tick": first, "first_s": first and first * 1e-3}
    found |= {"first_signals": ["x_m", "v_m"] if first else []}
    return found | others


CASES = [
    ([user(0.0)], True, "is exact: force and position of all ticks are equal."),
    ([user(0.0, missing=24)], True, "not exact: not all ticks can be compared."),
    ([user(0.02, 510)], True, "differ by up to 0.02 N, from tick 510 of user1"),
    ([user(0.21, 510)], False, "0.21 N, from tick 510 of user1 on."),
    ([user(0.0), user(None)], False, "does NOT reproduce the recording: not all ticks can be"),
    ([], False, "does NOT reproduce the recording: not all ticks can be compared."),
    ([user(0.0), user(1.5)], None, "Replayed with master.impedance = 40: forces differ by"),
]  # fmt: skip


@pytest.mark.parametrize(("found", "same", "said"), CASES)
def test_only_a_replay_whose_every_tick_was_compared_is_exact(found, same, said):
    changes = {"master.impedance": 40}
    result = SimpleNamespace(differences=found, changes=changes)
    text = lead(result, same)
    assert said in text
    assert ("is exact" in text) == (said == CASES[0][2])


def by_topic(messages):
    topics = dict.fromkeys(each.topic for each in messages)
    return {topic: [each for each in messages if each.topic == topic] for topic in topics}


def message(at_s, topic, kind, content):
    at_ns = round(at_s * 1e9)
    return RawMessage(topic, kind, at_ns, at_ns, serialize_message(content))


def target(at_s, x, *, user="user1", frame="world", turn=(0.0, 0.0, 0.0)):
    """A pose turned by ``turn`` [rad]."""
    target = PoseStamped()
    target.header.frame_id = frame
    point = target.pose.position
    point.x, point.y, point.z = x, 2.0 * x, 3.0 * x
    q = Rotation.from_rotvec(turn).as_quat().tolist()
    for name, each in zip("xyzw", q, strict=True):
        setattr(target.pose.orientation, name, each)
    return message(at_s, f"/lab/{user}/hand/target", schemas.POSE, target)


def held(at_s, value):
    return message(at_s, "/lab/user1/hand/held", schemas.FLAG, Bool(data=value))


def test_targets_are_read_as_the_master_took_them():
    messages = [
        target(1.0, 0.01, frame=""),
        target(1.2, math.nan),
        target(1.1, 0.02, frame="handle of the first user"),
        held(1.3, False),
        target(1.4, 0.03),  # does not count
        held(1.5, True),
        target(1.6, 0.04),
        target(1.6, 0.5, user="user2"),
        target(1.7, 0.6)._replace(data=b"\0\1\0\0"),
    ]
    found = hand_targets(by_topic(messages), zero_ns=10**9)
    assert sorted(found) == ["user1", "user2"]
    np.testing.assert_allclose(found["user1"].time_s, [0.0, 0.1, 0.2, 0.3, 0.6])
    expected = [[0.01, 0.02, 0.03], [0.02, 0.04, 0.06], [math.nan] * 3, [math.nan] * 3]
    np.testing.assert_allclose(found["user1"].position, [*expected, [0.04, 0.08, 0.12]])

    assert all(map(is_of_hand, messages))
    assert not is_of_hand(message(0.0, "/lab/goal", schemas.POSE, PoseStamped()))
    assert not is_of_hand(message(0.0, "/hand/target", schemas.FLAG, Bool()))


def test_orientations_of_targets_are_turns_since_the_identity_added_up():
    """About one axis beyond a whole turn, then about another; let go between."""
    turns = [[0.0, 0.0, 2.0], [0.0, 0.0, 4.0], [0.0, 0.0, 7.0]]
    messages = [target(i * 0.1, 0.01, turn=turn) for i, turn in enumerate(turns)]
    messages.insert(2, held(0.15, False))
    messages.insert(3, held(0.16, True))
    q = Rotation.from_rotvec([0.3, 0.0, 0.0]) * Rotation.from_rotvec(turns[-1])
    messages.append(target(0.4, 0.01, turn=q.as_rotvec()))
    found = hand_targets(by_topic(messages), zero_ns=0)["user1"]
    added = [[0, 0, 2], [0, 0, 4], [0, 0, 4], [0, 0, 7], [0.3, 0, 7]]
    np.testing.assert_allclose(found.turn, added, atol=1e-12)
    six = SimpleNamespace(server=ServerParams(lever_m=0.1), dof=6)
    np.testing.assert_allclose(found.ways(six)[-1], [0.01, 0.02, 0.03, 0.03, 0.0, 0.7])
    assert found.ways(SimpleNamespace(server=ServerParams(), dof=2)).shape == (5, 2)


def remote_scenario():
    texts = ["user1.operator.kind=remote", "task.kind=hold"]
    return scenarios.load("carry_16ms", settings_texts=texts, duration_s=3.0)


def test_targets_stay_at_their_ticks_behind_a_pause_of_the_loop():
    """A hand moves on in 99 ticks of a pause of 250; the target comes 50 ticks behind it."""
    scenario = remote_scenario()
    recorded = SimpleNamespace(
        live=True, targets={"user1": HandTargets(np.array([0.4]), np.array([[0.01, 0.0, 0.0]]))}
    )
    ran_ns = 1_000_000 * np.arange(800)
    ran_ns[100:350] = -1
    _, table = remote_hand(scenario.users[0], recorded, ran_ns, scenario)
    made_up_for = 99
    assert list(table.ticks) == [100 + made_up_for + 50]


@pytest.mark.parametrize("seed", range(4))
def test_a_target_moves_the_device_as_it_did_whatever_ticks_the_loop_missed(seed):
    """The node's device reads and makes up for what was missed; the replay has every tick."""
    scenario, rng = remote_scenario(), np.random.default_rng(seed)
    mine, ran = scenario.users[0], np.arange(800) == 0
    for begin in rng.integers(0, 800, 12):
        ran[begin : begin + rng.integers(1, 80)] = True
    taken = [k for k in range(800) if ran[k] and rng.random() < 0.3]
    places = 0.01 * rng.normal(size=len(taken))
    force = rng.normal(0.0, 0.5, 800)

    plain = replace(vendor_setup("simulated"), start_m=0.0, task=scenario.task)
    device = SimulatedDevice(replace(plain, device=mine.device, operator=mine.operator))
    waiting = []
    device._plant.listen(lambda: [waiting.pop()] if waiting else [])
    device.couple()
    live = {}
    for k in np.flatnonzero(ran).tolist():
        waiting += [places[taken.index(k)]] if k in taken else []
        live[k] = device.read(k * 10**6).f_h
        device.write(force[k])

    times = np.array(taken) * 1e-3 + 1e-4  # before the loop looked for packets
    targets = HandTargets(times, np.outer(places, [1.0, 0.0, 0.0]))
    recorded = SimpleNamespace(live=True, targets={"user1": targets})
    ran_ns = np.where(ran, np.arange(800) * 10**6 + 200_000, -1)
    plant = DevicePlant(
        mine.device, remote_hand(mine, recorded, ran_ns, scenario), (0.0,), tick_s=1e-3
    )
    last = 0
    for k in range(800):
        last = k if ran[k] else last
        if k - last < round(CATCH_UP_S / 1e-3):
            f_h = plant.sense(True).f_h
            assert not ran[k] or f_h == live[k], k
            plant.step(force[last])
    assert np.ptp(list(live.values())) > 1.0 and not ran.all()


def test_a_replay_of_a_replay_has_no_targets_and_says_so():
    scenario = remote_scenario()
    recorded = simulate_one(scenario)
    recorded.source = "replayed"
    with pytest.raises(RecordingError, match="holds no targets of a remote hand"):
        replay(recorded, scenario, scenario)
