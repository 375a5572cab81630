# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Server and masters as processes, joined by remapping: coupling, faults, rejoining."""

import contextlib
import math
import re
import signal

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from support.packer import Packer
from support.processes import NodeProcess, refused, ros
from visualization_msgs.msg import Marker, MarkerArray

from pmwvc_core.params import DeviceParams, MasterParams, OperatorParams, SafetyParams
from pmwvc_core.runtime import messages
from pmwvc_core.runtime.topics import RECORDED_QOS, WAVE_QOS
from pmwvc_core.transport.packet import FLAG_DIRECT
from pmwvc_msgs.msg import MasterTrace, ServerTrace, Wave
from pmwvc_server.node import main

pytestmark = [pytest.mark.integration]

SIDES = {"user1": -1, "user2": 1}
STEP_N = (
    SafetyParams().max_slew * MasterParams().tick_s + 1e-9
)  # largest change of force in a tick
BILATERAL = {"server.contact": "bilateral", "server.object_damping": 20.0}


def start_server(**parameters):
    given = {name.replace("__", "."): value for name, value in parameters.items()}
    values = {"users": list(SIDES), "channel": "plain"} | given
    return NodeProcess("pmwvc_server.node", values)


def start_master(user, **parameters):
    """A master of a user who presses on the object with 1 N, without a network between."""
    side = SIDES[user]
    values = {
        "channel": "plain",
        "side": side,
        "operator": OperatorParams(kind="constant", force=-side * 1.0),
        "device": DeviceParams(damping=10.0, workspace_m=5.0),  # drifts slowly when let go
    }
    values |= {name.replace("__", "."): value for name, value in parameters.items()}
    ends = [f"wave_{way}:=/server/{user}/wave_{way}" for way in ("up", "down")]
    arguments = ["-r", f"__ns:=/{user}", "-r", ends[0], "-r", ends[1]]
    return NodeProcess("pmwvc_master.node", values, arguments=arguments)


def record(peer, kind, topic):
    """Every message of a trace: also a busy test must not lose one."""
    messages = []
    peer.node.create_subscription(kind, topic, messages.append, RECORDED_QOS)
    return messages


class Session:
    """A server and two masters, what they publish, and waiting for it."""

    def __init__(self, stack, peer, **parameters):
        self.stack, self.peer, self.parameters = stack, peer, parameters
        self.steps = record(peer, ServerTrace, "/server/trace")
        self.blocks = {user: record(peer, MasterTrace, f"/{user}/trace") for user in SIDES}
        self.server = stack.enter_context(start_server(**parameters))
        self.masters = {}
        for user in SIDES:
            self.start(user)

    def start(self, user):
        shared = {k: v for k, v in self.parameters.items() if k in ("controller", "dof")}
        self.masters[user] = self.stack.enter_context(start_master(user, **shared))

    def until_states(self, user1, user2):
        """Wait until both masters are in a state."""
        wanted = {"user1": user1, "user2": user2}
        self.peer.until(
            lambda: all(b and b[-1].state == wanted[u] for u, b in self.blocks.items())
        )

    def steps_more(self, count):
        """Wait for some more steps of the server."""
        seen = len(self.steps)
        self.peer.until(lambda: len(self.steps) >= seen + count)

    def settled(self):
        """Wait until both press with 1 N and nothing moves any more."""

        def rests():
            last = self.steps[-25:]
            return len(last) == 25 and all(
                abs(abs(force) - 1.0) < 0.01 for step in (last[0], last[-1]) for force in step.f_s
            )

        self.peer.until(rests)

    def force(self, user, since=0):
        """Applied force, tick by tick, with the places where ticks are missing."""
        blocks = self.blocks[user][since:]
        force = np.concatenate([np.array(block.f_applied) for block in blocks])
        ticks = np.concatenate(
            [block.first_tick + np.arange(len(block.f_applied)) for block in blocks]
        )
        return force, np.diff(ticks) == 1


@contextlib.contextmanager
def session(**parameters):
    with contextlib.ExitStack() as stack:
        peer = stack.enter_context(ros())
        yield Session(stack, peer, **parameters)


@pytest.fixture(scope="module")
def pressed():
    """A session in which both press and nothing moves; whoever looks at it leaves it so."""
    with session(**BILATERAL) as run:
        run.until_states(MasterTrace.COUPLED, MasterTrace.COUPLED)
        run.settled()
        yield run


def no_step_of_force(run, user, since=0):
    force, consecutive = run.force(user, since)
    return np.abs(np.diff(force))[consecutive].max() <= STEP_N


@pytest.mark.parametrize("controller", ["pmwvc", "direct"])
def test_two_users_press_the_cube_and_get_its_force(controller):
    with session(controller=controller, **BILATERAL) as run:
        run.until_states(MasterTrace.COUPLED, MasterTrace.COUPLED)
        run.settled()
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
        assert [m.stop() for m in run.masters.values()] == [0, 0]
        run.peer.until(lambda: list(run.steps[-1].state) == [ServerTrace.ABSENT] * 2)
        assert run.server.stop() == 0
        for user in SIDES:  # they said goodbye: the last before is not that they fell silent
            news = [line for line in run.server.output.splitlines() if f"{user} " in line]
            assert news[-1].endswith("left") and "is coupled" in news[-2], news


def test_contact_object_and_coupling_change_in_flight_without_energy_or_a_jump():
    with session(**BILATERAL) as run:
        run.until_states(MasterTrace.COUPLED, MasterTrace.COUPLED)
        run.settled()
        before = run.steps[-1]
        stiff = {"server.contact_stiffness": 3000.0, "user2.server.contact_damping": 20}
        assert run.peer.set_parameters("/server", stiff) == ["", ""]
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
            "server.contact_stiffness": 1e9,
            "server.object_size_m": 0.1,
            "server.object_mass": 0.0,
        }
        reasons = run.peer.set_parameters("/server", refused)
        words = ["fixed once running", "out of range", "read-only", "out of range"]
        for reason, text in zip(reasons, words, strict=True):
            assert text in reason
        assert run.peer.set_parameters("/server", {"paused": True}) == [""]
        run.until_states(MasterTrace.DAMPING, MasterTrace.DAMPING)
        still, count = run.steps[-1], len(run.steps)
        run.peer.until(lambda: not any(run.blocks["user1"][-1].f_applied))  # let go
        assert len(run.steps) == count
        assert run.peer.set_parameters("/server", {"paused": False}) == [""]
        run.until_states(MasterTrace.COUPLED, MasterTrace.COUPLED)
        run.settled()
        again = next(step for step in run.steps if step.step == still.step + 1)
        assert again.x_o[0] == pytest.approx(still.x_o[0], abs=1e-3)
        assert no_step_of_force(run, "user1") and no_step_of_force(run, "user2")


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({"server.object_mass": -2.0}, r"server.object_mass = -2.0: must be 0.001..1000 kg"),
        (
            {"server.coupling": "explicit"},
            r"server.coupling = 'explicit': must be one of implicit",
        ),
        ({"users": ["user1", "user1"]}, r"users: 'user1' is there twice"),
        ({"user1.server.contact_stifness": 1.0}, r"did you mean user1.server.contact_stiffness"),
        ({"controller": "magic"}, r"controller = 'magic': must be one of pmwvc, direct"),
    ],
)
def test_a_wrong_setting_ends_the_server_with_one_clear_line(parameters, text):
    assert re.search(text, refused(main, parameters))


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
