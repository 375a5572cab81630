# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Server and masters as processes, joined by remapping: coupling, faults, rejoining."""

import math
import signal

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from support.packer import Packer
from support.two_masters import BILATERAL, SIDES, no_step_of_force, session, start_server
from visualization_msgs.msg import Marker, MarkerArray

from pmwvc_core.params import MasterParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import WAVE_QOS
from pmwvc_core.transport.packet import FLAG_DIRECT
from pmwvc_msgs.msg import MasterTrace, ServerTrace, Wave

pytestmark = [pytest.mark.integration]


@pytest.fixture(scope="module")
def pressed():
    """A session in which both press and nothing moves; whoever looks at it leaves it so."""
    with session(**BILATERAL) as run:
        run.until_states(MasterTrace.COUPLED, MasterTrace.COUPLED)
        run.settled()
        yield run


def press(run):
    """Both press with 1 N, and no step of the server is missing."""
    run.steps_more(50)
    run.settled()
    run.peer.until(lambda: np.ptp([step.x_o[0] for step in run.steps[-25:]]) < 1e-4)
    last = run.steps[-25:]
    for user, sign in (("user1", 1.0), ("user2", -1.0)):
        force, _ = run.force(user, since=-10)
        assert force == pytest.approx(np.full(len(force), sign), abs=0.02)
    steps = [step.step for step in run.steps]
    assert np.all(np.diff(steps) == 1)
    assert list(last[-1].state) == [ServerTrace.COUPLED] * 2


def test_directly_coupled_they_press_the_cube_too_and_say_goodbye_at_the_end():
    """The first one here: the session of the others has the same topics."""
    with session(controller="direct", **BILATERAL) as run:
        run.until_states(MasterTrace.COUPLED, MasterTrace.COUPLED)
        run.settled()
        press(run)
        assert [m.stop() for m in run.masters.values()] == [0, 0]
        run.peer.until(lambda: list(run.steps[-1].state) == [ServerTrace.ABSENT] * 2)
        assert run.server.stop() == 0
        for user in SIDES:  # the last before is not that they fell silent
            news = [line for line in run.server.output.splitlines() if f"{user} " in line]
            assert news[-1].endswith("left") and "is coupled" in news[-2], news


def test_two_users_press_the_cube_and_get_its_force(pressed):
    press(pressed)


def test_packets_of_a_rogue_publisher_are_counted_and_harmless(pressed):
    run = pressed
    statuses = run.peer.collect(DiagnosticArray, "/diagnostics")
    types = messages.live_types()
    out = run.peer.node.create_publisher(Wave, "/server/user1/wave_up", WAVE_QOS)
    run.peer.until(lambda: out.get_subscription_count() >= 1)
    true = run.peer.collect(Wave, "/server/user1/wave_up")
    run.peer.until(lambda: true)
    count = len(run.steps)
    packer = Packer(5, period=MasterParams().frame_s)

    def send(**fields):
        message = messages.wave(types, packer.pack(0.0, 0.0, 0), 0)
        for name, value in fields.items():
            setattr(message, name, value)
        out.publish(message)

    old = true[0]
    for _ in range(10):
        send(wave=[math.nan])
        send(wave=[1e300])
        send(**{name: [0.1, 0.2, 0.3] for name in ("wave", "integral", "position")})
        send(epoch=old.epoch, seq=old.seq, sent_ns=old.sent_ns)
        send(flags=FLAG_DIRECT)
        run.steps_more(1)

    def counted():
        found = [s for array in statuses for s in array.status if s.name == "/server"]
        values = {pair.key: pair.value for pair in found[-1].values} if found else {}
        refused = ("not finite", "wrong length", "too large", "duplicate")
        names = [f"user1: packets {verdict}" for verdict in refused]
        return all(int(values.get(name, 0)) for name in (*names, "packets of another controller"))

    run.peer.until(counted)
    run.settled()
    after = run.steps[count:]
    assert np.isfinite([step.f_s for step in after]).all()
    assert max(abs(step.f_s[0]) for step in after) < 1.5
    assert no_step_of_force(run, "user1")


def test_the_scene_is_shown_to_whoever_looks(pressed):
    run = pressed
    scenes = run.peer.collect(MarkerArray, "/markers")
    last = run.peer.until(lambda: scenes and scenes[-1])
    names = {marker.ns: marker for marker in last.markers}
    assert {"object", "target", "user1/avatar", "user1/force"} <= set(names)
    assert all(marker.header.frame_id == "world" for marker in last.markers)
    assert names["user2/avatar"].action == Marker.ADD
    assert names["user1/avatar"].pose.position.x < names["user2/avatar"].pose.position.x


def test_contact_object_and_coupling_change_in_flight_without_energy_or_a_jump(pressed):
    run = pressed
    before = run.steps[-1]
    stiff = {f"user{n}.server.contact_stiffness": 3000.0 for n in (1, 2)}
    stiff["user2.server.contact_damping"] = 20
    assert run.peer.set_parameters("/server", stiff) == [""] * 3
    run.peer.until(lambda: run.steps[-1].potential < 0.5 * before.potential)
    run.settled()
    after = run.steps[-1]
    spring = sum(force**2 for force in before.f_s) / (2.0 * 500.0)
    assert before.potential == pytest.approx(spring, rel=0.05)
    assert after.potential == pytest.approx(spring / 6.0, rel=0.05)
    taken = [s for s in run.steps if before.step <= s.step <= after.step]
    stored = np.array([s.potential + s.kinetic for s in taken])
    came = np.array([sum(s.energy_u_s) - sum(s.energy_v_s) for s in taken])
    lost = np.array([s.dissipated for s in taken])
    np.testing.assert_allclose(np.diff(stored + lost), np.diff(came), atol=1e-12)
    assert np.abs(np.diff([s.x_s for s in taken], axis=0)).max() < 1e-3
    assert no_step_of_force(run, "user1") and no_step_of_force(run, "user2")
    assert run.peer.set_parameters("/server", {"server.coupling": "unwrapped"}) == [""]
    run.steps_more(50)
    run.settled()
    refused = {
        "server.coupling": "unknown",
        "user1.server.contact_stiffness": 1e9,
        "server.object_size_m": 0.1,
        "server.object_mass": 0.0,
    }
    reasons = run.peer.set_parameters("/server", refused)
    words = ["fixed once running", "out of range", "read-only", "out of range"]
    for reason, text in zip(reasons, words, strict=True):
        assert text in reason
    as_before = {f"user{n}.server.contact_stiffness": 500.0 for n in (1, 2)}
    as_before["server.coupling"] = "implicit"
    assert run.peer.set_parameters("/server", as_before) == [""] * 3
    run.settled()


def test_a_killed_master_leaves_a_steady_cube_and_comes_back(pressed):
    run = pressed
    count, since = len(run.steps), len(run.blocks["user1"])
    run.masters["user2"].process.send_signal(signal.SIGKILL)
    run.peer.until(lambda: run.steps[-1].state[1] == ServerTrace.DAMPING)
    run.peer.until(lambda: run.steps[-1].state[1] == ServerTrace.ABSENT)
    gone = run.steps[count:]
    # 1 N against an object damping of 20 N s/m: 50 mm/s at most, and no stored force let loose
    assert max(abs(step.xd_o[0]) for step in gone) < 0.06
    assert no_step_of_force(run, "user1", since)
    run.blocks["user2"].clear()
    run.start("user2")
    run.until_states(MasterTrace.COUPLED, MasterTrace.COUPLED)
    run.settled()
    assert no_step_of_force(run, "user1", since)
    assert no_step_of_force(run, "user2")
    epochs = {block.epoch for block in run.blocks["user2"]}
    assert len(epochs) == 1


def test_a_killed_server_leaves_the_masters_damping_and_a_new_one_couples_them_again(pressed):
    run = pressed
    run.server.process.send_signal(signal.SIGKILL)
    run.until_states(MasterTrace.DAMPING, MasterTrace.DAMPING)
    count = {user: len(blocks) for user, blocks in run.blocks.items()}
    run.server = run.stack.enter_context(start_server(**BILATERAL))
    run.until_states(MasterTrace.COUPLED, MasterTrace.COUPLED)
    run.steps.clear()
    run.settled()
    assert run.steps[-1].step > run.steps[0].step
    for user in SIDES:
        damping = [b for b in run.blocks[user] if b.state == MasterTrace.DAMPING]
        assert damping and damping[0].reason
        assert no_step_of_force(run, user, since=max(count[user] - 200, 0))
