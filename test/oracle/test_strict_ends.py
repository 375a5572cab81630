# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Both ends of the strict channel equal second models of them, tick by tick and step by step,
whatever the network does.
"""

import numpy as np
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st
from oracle.strict_contact_model import Face, Spring
from oracle.strict_master_model import MasterModel
from oracle.strict_sender import NETWORKS, Sender
from oracle.strict_server_model import ServerModel, UserModel
from support.session_given import session_given

from pmwvc_core.ends.server_end import ServerEnd
from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.frame import DeviceSample, Presence
from pmwvc_core.params import ContactParams, MasterParams, SafetyParams, ServerParams, TaskParams
from pmwvc_core.params.user import ServerTimes
from pmwvc_core.scenario.scenario import User
from pmwvc_core.transport.packet import FLAG_ANEW, FLAG_CHALLENGE, FLAG_SHORT, FLAG_WAITING

TICK_NS = 1_010_000  # no time constant is a multiple of it: no comparison is decided by rounding
H = TICK_NS * 1e-9
TIMEOUT_S = 0.03
GAP_M, SIZE_M = 0.001, 0.06
NEAR = 1e-4  # of waves [sqrt(W)] and forces [N]: the root of what rounding leaves of an energy
CLOSE = 1e-6  # of what is summed of them
SIDES = (-1, 1)
NO_SHRINKING = (Phase.explicit, Phase.reuse, Phase.generate)
BOTH = NETWORKS | {
    "seed": st.integers(0, 2**32 - 1),
    "dof": st.sampled_from((1, 1, 3)),
    "b": st.sampled_from((5.0, 25.0, 80.0)),
    "store_j": st.sampled_from((0.0, 2e-3, 0.05)),
    "rises": st.sampled_from((1.0, 1.0, 4.0, 12.0)),
    "stalls": st.booleans(),
    "restarts": st.booleans(),
    "release_s": st.sampled_from((0.15, 5.0)),
}
ROUGH = {
    **{
        "seed": 7,
        "dof": 1,
        "b": 25.0,
        "rises": 4.0,
        "store_j": 2e-3,
        "stalls": True,
        "restarts": False,
    },
    **{"wave": 0.3, "paid": 1.0, "loss": 0.1, "late": 0.2, "outages_s": [0.2, 0.5]},
    **{"asks": True, "hostile": False, "release_s": 5.0},
}


def same(found, wanted, what, *, within=CLOSE):
    np.testing.assert_allclose(np.ravel(found) - wanted, 0.0, atol=within, err_msg=what)


def same_packet(sent, expected, what, *names):
    """Compare packets, None where none is sent."""
    assert (sent is None) == (expected is None), what
    if sent is not None:
        for name in ("seq", "integral", "energy", *names):
            same(getattr(sent, name), getattr(expected, name), f"{name} {what}")
        same(sent.wave, expected.wave, f"wave sent {what}", within=NEAR)
        assert bool(sent.flags & FLAG_WAITING) == expected.waiting, what


# --- the force loop --------------------------------------------------------------------------

TICKS = 1200
NAMES = {
    "node": lambda model: model.node_j,
    "playout_given": lambda model: model.wave.out_j,
    "playout_released": lambda model: model.wave.passed_j,
    "playout_free": lambda model: model.wave.free_j,
    "playout_discarded": lambda model: model.wave.dropped_j,
}
loops = st.fixed_dictionaries(
    BOTH
    | {
        "count_m": st.sampled_from((0.0, 0.0, 55e-6, 300e-6)),
        "differences": st.booleans(),
        "rate_drop": st.sampled_from((1, 4, 8, 20)),
        "server_ticks": st.sampled_from((1, 5, 8)),
    }
)


def loop_of(case):
    own = {name: case[name] for name in ("rate_drop", "store_j")}
    high = case["rises"] * case["b"]
    master = MasterParams(impedance=case["b"], contact_impedance=high, tick_s=H, **own)
    limits = {"soft_start_s": 0.05, "timeout_s": TIMEOUT_S, "release_s": case["release_s"]}
    safety = SafetyParams(max_force=5.0, max_slew=4000.0, **limits)
    server_s = case["server_ticks"] * H
    loop = UserEnd(
        User("user1", master=master, given_safety=safety),
        session_given(channel="strict", dof=case["dof"], server=ServerParams(period_s=server_s)),
        epoch=5,
    )
    limits = {"soft_s": 0.05, "release_s": case["release_s"], "most_n": 5.0, "slew_n": 4000.0 * H}
    times = {"h": H, "server_s": server_s, "timeout_s": TIMEOUT_S}
    own |= {"dof": case["dof"], "b": case["b"], "rises": case["rises"]}
    return loop, MasterModel(limits=limits, **times, **own)


def motion(rng, dof):
    """Return position and velocity over time: a slow hand, with a little of a fast one."""
    hertz, metres = np.array([0.3, 1.7, 14.0]), np.array([0.02, 0.004, 0.0002])
    phase = rng.uniform(0.0, 2.0 * np.pi, (3, dof))

    def at(k):
        angle = 2.0 * np.pi * hertz[:, None] * k * H + phase
        x = (metres[:, None] * np.sin(angle)).sum(axis=0)
        xd = (2.0 * np.pi * hertz[:, None] * metres[:, None] * np.cos(angle)).sum(axis=0)
        return x, xd

    begun = at(2)[0]
    # a first step as small as no encoder's tells that positions are exact
    return lambda k: at(k) if k > 1 else (begun - 1e-9 * (2 - k), np.zeros(dof))


MASTER = ROUGH | {"count_m": 0.0, "differences": True, "rate_drop": 8, "server_ticks": 8}


@settings(max_examples=5, derandomize=True, phases=NO_SHRINKING)
@given(case=loops)
@example(case=MASTER)
@example(case=MASTER | {"dof": 3, "restarts": True, "late": 0.6, "hostile": True})
@example(case=MASTER | {"count_m": 55e-6, "stalls": False})
@example(case=MASTER | {"count_m": 300e-6, "dof": 3, "differences": False})
@example(case=MASTER | {"release_s": 0.15, "store_j": 0.0, "paid": 1.4, "wave": 2.0})
def test_every_tick_of_the_force_loop_equals_the_second_model(case):
    rng = np.random.default_rng(case["seed"])
    loop, model = loop_of(case)
    every = case["server_ticks"]
    server = Sender(case, rng, dof=case["dof"], every=every, tick_ns=TICK_NS, ends=TICKS)
    moves = motion(rng, case["dof"])
    scalar = (lambda a: float(a[0])) if case["dof"] == 1 else np.copy
    echo_ns, k, before = 0, 0, None
    while k < TICKS:
        x, xd = moves(k)
        if k % every == 0:
            server.send(k, echo_ns, x)
        if case["restarts"] and k == TICKS // 2:
            server.restart(k, 300)
        arrived, known = server.arrived(k)
        seen = xd + 1e-3 * rng.normal(size=case["dof"])  # a velocity is an estimate
        if case["count_m"]:
            x = np.floor(x / case["count_m"]) * case["count_m"]
            if case["differences"] and k:
                seen = (x - before[1]) / ((k - before[0]) * H)
        before = k, x
        f, sent, row = loop.tick(k, k * TICK_NS, DeviceSample(scalar(x), scalar(seen)), arrived)
        packet, asked, applied, v = model.tick(k, k * TICK_NS, x, seen, known)
        same_packet(sent, packet, f"at {k}", "period")
        if sent is not None:
            echo_ns = sent.sent_ns
            assert bool(sent.flags & FLAG_SHORT) == packet.short, k
        same(row[7], v, f"wave at {k}", within=NEAR)
        same(row[3], asked, f"force asked at {k}", within=NEAR)
        same(f, applied, f"force at {k}", within=NEAR)
        accounts = loop.report().accounts
        for name, of in NAMES.items():
            same(accounts[name], of(model), f"{name} at {k}")
        k += int(rng.choice([1, 1, 1, 30, 60])) if case["stalls"] and k % 97 == 96 else 1


# --- the server ------------------------------------------------------------------------------

SERVER_TICKS = 2400
servers = st.fixed_dictionaries(
    BOTH
    | {
        "frame": st.sampled_from((1, 8, 20)),
        "step": st.sampled_from((3, 8, 17)),
        "grips": st.booleans(),
        "wall": st.booleans(),
        "stiffness": st.sampled_from((0.0, 500.0, 5000.0)),
        "damping": st.sampled_from((1.0, 10.0)),
        "drag": st.sampled_from((0.0, 4.0)),
        "leaves": st.booleans(),
    }
)
SERVER = ROUGH | {
    **{"frame": 8, "step": 8, "grips": True, "wall": False, "stiffness": 500.0},
    **{"damping": 10.0, "drag": 4.0, "leaves": False},
}


def server_of(case):
    b, h, frame_s, dof = case["b"], case["step"] * H, case["frame"] * H, case["dof"]
    law = {"contact_stiffness": case["stiffness"], "contact_damping": case["damping"]}
    contact = ContactParams(contact="grip" if case["grips"] else "bilateral", gap_m=GAP_M, **law)
    high, frame = case["rises"] * b, case["frame"]
    master = MasterParams(impedance=b, contact_impedance=high, rate_drop=frame, tick_s=H)
    server = ServerParams(
        environment="wall" if case["wall"] else "cube",
        period_s=h,
        store_j=case["store_j"],
        object_mass=0.5,
        object_damping=case["drag"],
        object_size_m=SIZE_M,
    )
    session = session_given(
        users=[User(f"user{side}", side=side, master=master, contact=contact) for side in SIDES],
        channel="strict",
        dof=dof,
        server=server,
        task=TaskParams(kind="hold"),
        times=ServerTimes(TIMEOUT_S, case["release_s"], 0.5),
    )
    own = {
        "rises": case["rises"],
        "b": b,
        "store_j": case["store_j"],
        "frame_s": frame_s,
        "timeout_s": TIMEOUT_S,
        "h": h,
    }
    users = []
    for side in SIDES:
        spring = Spring(dof, *law.values())
        face = Face(*law.values(), side=side, size=SIZE_M, gap=GAP_M)
        users.append(UserModel(dof, face if case["grips"] else spring, **own))
    own = {"mass": None if case["wall"] else 0.5, "damping": case["drag"]}
    model = ServerModel(users, dof=dof, h=h, release_s=case["release_s"], **own)
    return ServerEnd(session), model


def compare_users(row, answers, model, wanted, at):
    for i, (sent, expected) in enumerate(zip(answers, wanted, strict=True)):
        user, what = model.users[i], f"of user {i + 1} at {at}"
        same(row.energy_u_s[i], user.in_j, f"energy in {what}")
        same(row.energy_v_s[i], user.back_j, f"energy back {what}")
        same_packet(sent, expected, what, "position")
        if sent is None:
            assert row.state[i] is Presence.ABSENT
            continue
        assert bool(sent.flags & FLAG_CHALLENGE) == expected.asks, what
        assert sent.flags & FLAG_ANEW == expected.anew, what
        if expected.asks:
            continue
        same(row.u_s[i], expected.u, f"wave used {what}", within=NEAR)
        same(row.f_s[i], user.f, f"force {what}", within=NEAR)
        same(row.x_s[i], expected.x_s, f"avatar {what}")
        assert bool(sent.flags & FLAG_SHORT) == expected.short, what
        assert row.state[i] is (Presence.DAMPING if expected.damped else Presence.COUPLED), what


@settings(max_examples=5, derandomize=True, phases=NO_SHRINKING)
@given(case=servers)
@example(case=SERVER)
@example(case=SERVER | {"dof": 3, "grips": False, "restarts": True, "late": 0.6, "hostile": True})
@example(case=SERVER | {"wall": True, "release_s": 0.15, "leaves": True, "paid": 1.4})
def test_every_step_of_the_server_equals_the_second_model(case):
    case = case | {"grips": case["grips"] and case["dof"] == 1}
    rng = np.random.default_rng(case["seed"])
    dof, (step, model) = case["dof"], server_of(case)
    rules = {"dof": dof, "every": case["frame"], "tick_ns": TICK_NS, "ends": SERVER_TICKS}
    senders = [Sender(case, rng, places=False, **rules) for _ in SIDES]
    for sender, side in zip(senders, SIDES, strict=True):
        sender.push = np.full(dof, -side * 0.5 * case["wave"])  # towards the object
    echo_ns, missed = [0, 0], 0
    for now in range(SERVER_TICKS):
        for i, sender in enumerate(senders):
            if case["restarts"] and now == SERVER_TICKS // 2 + 300 * i:
                sender.restart(now, 200)
            if now % case["frame"] == 0:
                place = np.full(dof, SIDES[i] * 0.03 + rng.normal() * 0.003)
                leaves = case["leaves"] and 900 <= now < 900 + case["frame"]
                sender.send(now, echo_ns[i], place, leaving=leaves)
        if now % case["step"]:
            continue
        if case["stalls"] and missed < 12 and (missed or rng.random() < 0.01):
            missed += 1
            continue
        arrived = [sender.arrived(now) for sender in senders]
        missed_s, now_ns, missed = missed * case["step"] * H, now * TICK_NS, 0
        answers, row = step.tick(now_ns, [each for each, _ in arrived], missed_s)
        wanted = model.step(now_ns, [each for _, each in arrived], missed_s)
        compare_users(row, answers, model, wanted, now)
        echo_ns = [
            sent.sent_ns if sent else old for sent, old in zip(answers, echo_ns, strict=True)
        ]
        moving_j, springs_j = model.stored_j
        same(row.x_o, model.x, f"object at {now}")
        same(row.kinetic, moving_j, f"energy of motion at {now}")
        same(row.potential, springs_j, f"energy of the springs at {now}")
        same(row.dissipated, model.lost_j, f"heat at {now}")
        same(row.accounts["avatar_brakes"], sum(u.heat_j for u in model.users), f"brakes at {now}")
