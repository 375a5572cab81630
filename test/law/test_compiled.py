# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws compiled give the numbers of their source: environments, ends without waves, plants, and
what energy covers. A whole compiled session, of the strict channel and the implicit coupling:
``oracle/test_bulk_sessions.py``.
"""

import math

import numpy as np
import pytest
from support.laws import assert_same, in_bulk

from pmwvc_core.law.black_box.compensations import Pair, compensated
from pmwvc_core.law.black_box.touched import Visitors, exchange, visited
from pmwvc_core.law.channel.arrivals import arrive
from pmwvc_core.law.channel.packet import Packet
from pmwvc_core.law.port.master import (
    port_answer,
    port_measure,
    port_passed,
    port_send,
    port_tick,
)
from pmwvc_core.law.server.server_port import Came, environment_step, joined, left
from pmwvc_core.law.vectors import dot, each, plus, scaled
from pmwvc_core.law.wave.wave import affordable, repayment
from pmwvc_core.made.server import resting_server, server_params
from pmwvc_core.made.user import made_user
from pmwvc_core.params import DeviceParams, OperatorParams, TaskParams
from pmwvc_core.plant.device import device_step, resting_device, simulated_params
from pmwvc_core.plant.forces import RecordedForce, hand_force, recorded_params
from pmwvc_core.plant.hand import Place, RecordedHand, recorded_motion
from pmwvc_core.plant.hands import make_hand
from pmwvc_core.plant.remote_hand import TableHand, TableParams, remote_params, resting_remote
from pmwvc_core.scenario.reader import parse_scenario

H, TICK_S, STEPS = 0.008, 0.001, 120
MATRIX = {"channel": "strict", "dof": 2, "master": {"impedance_matrix": "30 6; 6 20"}}
# Of one user, which is compiled in a third of the time; without waves there are two.
ENVIRONMENTS = {
    "coupled axes, unwrapped": MATRIX | {"server": {"coupling": "unwrapped"}},
    "a cube as a black box": {"server": {"coupling": "unknown", "environment": "cube"}},
}
# Of all other black boxes what differs from that one.
BOXES = (
    ("active_wall", "printed"),
    ("wall_with_slope", "corrected"),
    ("hunt_crossley", "none"),
    ("cube_with_impedance", "ledger"),
    ("hunt_crossley_with_impedance", "none"),
)
WITHOUT_WAVES = (("virtual_coupling", 1), ("tdpa", 2), ("pspm", 1))


def scenario_of(**given):
    return parse_scenario({"name": "small", "duration_s": 1.0, "users": 1, **given})


def pushed_environment(p, s, users, axes):
    """Push, slide and let go; every user waits for packets for a while, and one begins anew."""
    for n in range(STEPS):
        s = environment_step(p, s, each(wave_of, (users,), n, axes))
        if n == 90:
            port, _ = left(s.ports[0])
            port, _ = joined(port, each(place, (axes,)), s.body)
            s = s._replace(ports=(port, *s.ports[1:]))
    return s


def place(axis):
    return -0.05 if axis == 0 else 0.0


def wave_of(user, n, axes):
    sign, waits = (1.0 if user == 0 else -1.0), 60 + 10 * user < n < 80
    wave = each(component, (axes,), sign, n)
    return Came(wave, each(place, (axes,)), waits, 1e-4 * n, ())


def component(axis, sign, n):
    return sign * (1.5 - axis) * math.sin((0.06 + 0.04 * axis) * n)


place.__module__ = wave_of.__module__ = component.__module__ = "pmwvc_core.law.driver"


@pytest.mark.parametrize("given", ENVIRONMENTS.values(), ids=ENVIRONMENTS)
def test_environments(given):
    compare_environments(scenario_of(controller="pmwvc", **{"channel": "strict"} | given))


def compare_environments(scenario):
    p = server_params(scenario.users, scenario, scenario.server)
    rest, axes = resting_server(scenario.users, scenario, p).environment, range(scenario.dof)
    at = [tuple(-side if axis == 0 else 0.0 for axis in axes) for side in (0.05, -0.05)]
    ports = [joined(*each, rest.body)[0] for each in zip(rest.ports, at, strict=False)]
    numbers = tuple(range(len(ports)))
    start = p.environment, rest._replace(ports=tuple(ports)), numbers, tuple(axes)
    wanted = pushed_environment(*start)
    assert wanted.dissipated_j != 0.0  # there was contact
    assert_same(in_bulk(pushed_environment)(*start), wanted)


def played_box(p, box, avatars, axes):
    """Swing one avatar into an environment and out; return what it leaves, and sums of forces and
    of the waves sent.
    """
    environment, compensation = box.environment, box.compensation
    forces, waves = each(swung, (axes,), 0), each(swung, (axes,), 0)
    at = each(swung, (axes,), 0)
    for n in range(STEPS):
        start, velocity = each(swung, (axes,), n), each(swinging, (axes,), n)
        environment = visited(environment, (n < 100,), (n == 0,), (start,))
        pushes = (avatars[0]._replace(u=scaled(velocity, 9.0)),)
        visitors = Visitors(pushes, (at,), (start,))
        environment, reply = exchange(environment, visitors, (velocity,), p)
        force, at = reply.avatars[0].f, reply.ends[0]
        avatars = each(gone_on, (avatars, reply.avatars), n < 99)
        wave = Pair(velocity, force, -dot(force, velocity))
        compensation, sent = compensated(compensation, (wave,), reply.stored_j, p.compensation)
        forces, waves = plus(forces, force), plus(waves, sent[0])
    return environment, compensation, forces, waves


def gone_on(avatar, moved, stays):
    return avatar._replace(present=stays, contact=moved.contact)


def swung(axis, n):
    return -0.04 + 0.03 * math.sin(0.1 * n)


def swinging(axis, n):
    return 0.3 * math.cos(0.1 * n)


swung.__module__ = swinging.__module__ = gone_on.__module__ = component.__module__


@pytest.mark.parametrize(("environment", "compensation"), BOXES)
def test_environments_and_compensations_of_black_boxes(environment, compensation):
    given = {"environment": environment, "compensation": compensation, "decoding": "late"}
    scenario = scenario_of(controller="pmwvc", server={"coupling": "unknown"} | given)
    p = server_params(scenario.users, scenario, scenario.server)
    rest = resting_server(scenario.users, scenario, p).environment
    port, _ = joined(rest.ports[0], (swung(0, 0),), rest.body)
    start = p.environment, rest.body, (port.avatar,), (0,)
    wanted = played_box(*start)
    assert abs(wanted[2][0]) > 1.0 and abs(wanted[3][0]) > 1.0
    assert_same(in_bulk(played_box)(*start), wanted)


def frame(s, arrivals, packet, x, xd, silent, p, rules):
    """Run a frame of a device's end in one tick."""
    arrivals = arrive(arrivals, packet, packet.sent_ns, rules)
    s = port_measure(s, x, xd, p)
    s, _, sent = port_send(s, arrivals, H, packet.number, 0.0, p)
    s = port_answer(s, arrivals, packet, packet.wave, silent, H, p)
    s, _, f = port_tick(s, arrivals, x, xd, p)
    return port_passed(s, f, p), arrivals, sent, f


@pytest.mark.parametrize(("controller", "axes"), WITHOUT_WAVES)
def test_both_ends_without_waves(controller, axes):
    scenario = scenario_of(controller=controller, dof=axes, users=2)
    compare_environments(scenario)
    loop, p = made_user(scenario.users[0], scenario)
    s, arrivals, bulk = loop.port, loop.arrivals, in_bulk(frame)
    rng, energy_j, x = np.random.default_rng(2), 0.0, np.array((-0.06, 0.0)[:axes])
    for n in range(100):
        energy_j += 1e-4 * float(rng.random())
        xd = rng.normal(size=axes) * 0.3 + (0.3 * np.sin(0.05 * n), 0.0)[:axes]
        x = x + H * xd
        wave, motion = (tuple((x + rng.normal(size=axes) * 0.01).tolist())), (x, xd)
        flags, fresh = (False, False, False, False), n in (0, 60)
        packet = Packet(
            n + 1, n, H, wave, (0.0,) * axes, energy_j, wave, *flags, 0, (), 0, fresh, 0, 0
        )
        at, silent = (tuple(each.tolist()) for each in motion), bool(rng.random() < 0.1)
        given = (s, arrivals, packet, *at, silent, p.port, p.arrivals)
        after = frame(*given)
        assert_same(bulk(*given), after, str(n))
        s, arrivals = after[:2]


def covered(wave, change, power):
    return affordable(wave, change, power), repayment(change, wave, power)


def test_what_energy_covers():
    rng, bulk = np.random.default_rng(3), in_bulk(covered)
    for _ in range(300):
        wave, change = (
            tuple((rng.normal(size=3) * rng.choice([0.0, 0.1, 1.0])).tolist()) for _ in "wc"
        )
        power = float(rng.normal() * rng.choice([0.0, 0.1, 1.0]))
        assert_same(bulk(wave, change, power), covered(wave, change, power))


def pushed_device(device, dp, hand, hp, f_m):
    x, xd = device.x, device.xd
    for tick in range(2000):
        hand, f_h = hand_force(hand, x, xd, tick >= 100, hp)
        device, x, xd = device_step(device, f_h, f_m, dp)
    return device, hand


def hands(at, axes):
    """Every hand, by its name."""
    task = TaskParams("carry", 0.2, 0.4, 0.9, 0.06, 0.02, 0.3, 0.1)
    rows = 0.02 * np.cumsum(np.random.default_rng(1).normal(size=(1500, axes)), axis=0)
    times, params = 30 * np.arange(50), OperatorParams()
    table = TableParams(remote_params(params, TICK_S), times, rows[::30], (0, 1), True)
    return {
        **{
            kind: make_hand(OperatorParams(kind=kind), task, at)
            for kind in ("constant", "sinusoid", "chirp", "hand", "remote")
        },
        "force": (RecordedForce(0), recorded_params(rows, axes, True, True)),
        "motion": (RecordedHand(0), recorded_motion(params, rows, at.start, TICK_S)),
        "table": (TableHand(resting_remote(at.start), 0, 0), table),
    }


def test_all_hands_on_smooth_and_rough_devices():
    at = Place(-1, 0.02, -0.03, TICK_S, 2)
    rough = DeviceParams(friction=0.3, workspace_m=0.05, encoder_step_m=1e-5, velocity="euler")
    bulk, ends = in_bulk(pushed_device), set()
    for device in (DeviceParams(damping=0.4, workspace_m=1.0), rough):
        dp = simulated_params(device, TICK_S)
        for name, (hand, hp) in hands(at, 2).items():
            given = (resting_device(at.start, dp), dp, hand, hp, (0.1, 0.1))
            wanted = pushed_device(*given)
            assert_same(bulk(*given), wanted, name)
            ends.add(wanted[0].x)
    assert len(ends) > 10  # no two hands do the same
