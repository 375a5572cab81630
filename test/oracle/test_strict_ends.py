# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The force loop on the strict channel equals a second model of it, tick by tick, whatever the
network does. The server's end has the same playout and receiver; what is its own: the coupling
(``test_meeting_environments.py``), the brake (``property/test_brakes.py``), the way out of a body
(``property/test_sliding_avatar.py``).
"""

import numpy as np
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st
from oracle.strict_master_model import MasterModel
from oracle.strict_sender import NETWORKS, Sender
from support.session_given import session_given

from pmwvc_core.ends.user_end import UserEnd
from pmwvc_core.frame import DeviceSample
from pmwvc_core.params import MasterParams, SafetyParams, ServerParams
from pmwvc_core.scenario.scenario import User
from pmwvc_core.transport.packet import FLAG_SHORT, FLAG_WAITING

TICK_NS = 1_010_000  # no time constant is a multiple of it: no comparison is decided by rounding
H = TICK_NS * 1e-9
TIMEOUT_S = 0.03
NEAR = 1e-4  # of waves [sqrt(W)] and forces [N]: the root of what rounding leaves of an energy
CLOSE = 1e-6  # of what is summed of them
NO_SHRINKING = (Phase.explicit, Phase.reuse, Phase.generate)
LOOPS = NETWORKS | {
    "seed": st.integers(0, 2**32 - 1),
    "dof": st.sampled_from((1, 1, 3)),
    "b": st.sampled_from((5.0, 25.0, 80.0)),
    "store_j": st.sampled_from((0.0, 2e-3, 0.05)),
    "rises": st.sampled_from((1.0, 1.0, 4.0, 12.0)),
    "stalls": st.booleans(),
    "restarts": st.booleans(),
    "release_s": st.sampled_from((0.15, 5.0)),
    "count_m": st.sampled_from((0.0, 0.0, 55e-6, 300e-6)),
    "differences": st.booleans(),
    "rate_drop": st.sampled_from((1, 4, 8, 20)),
    "server_ticks": st.sampled_from((1, 5, 8)),
}
ROUGH = {
    **{"seed": 7, "dof": 1, "b": 25.0, "rises": 4.0, "store_j": 2e-3, "stalls": True},
    **{"wave": 0.3, "paid": 1.0, "loss": 0.1, "late": 0.2, "outages_s": [0.2, 0.5]},
    **{"asks": True, "hostile": False, "release_s": 5.0, "restarts": False},
    **{"count_m": 0.0, "differences": True, "rate_drop": 8, "server_ticks": 8},
}


def same(found, wanted, what, *, within=CLOSE):
    np.testing.assert_allclose(np.ravel(found) - wanted, 0.0, atol=within, err_msg=what)


TICKS = 1200
NAMES = {
    "node": lambda model: model.node_j,
    "playout_given": lambda model: model.wave.out_j,
    "playout_released": lambda model: model.wave.passed_j,
    "playout_free": lambda model: model.wave.free_j,
    "playout_discarded": lambda model: model.wave.dropped_j,
}


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


@settings(max_examples=5, derandomize=True, phases=NO_SHRINKING)
@given(case=st.fixed_dictionaries(LOOPS))
@example(case=ROUGH)
@example(case=ROUGH | {"dof": 3, "restarts": True, "late": 0.6, "hostile": True})
@example(case=ROUGH | {"count_m": 55e-6, "stalls": False})
@example(case=ROUGH | {"count_m": 300e-6, "dof": 3, "differences": False})
@example(case=ROUGH | {"release_s": 0.15, "store_j": 0.0, "paid": 1.4, "wave": 2.0})
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
        assert (sent is None) == (packet is None), k
        if sent is not None:
            for name in ("seq", "integral", "energy", "period"):
                same(getattr(sent, name), getattr(packet, name), f"{name} at {k}")
            same(sent.wave, packet.wave, f"wave sent at {k}", within=NEAR)
            assert bool(sent.flags & FLAG_WAITING) == packet.waiting, k
            echo_ns = sent.sent_ns
            assert bool(sent.flags & FLAG_SHORT) == packet.short, k
        same(row[7], v, f"wave at {k}", within=NEAR)
        same(row[3], asked, f"force asked at {k}", within=NEAR)
        same(f, applied, f"force at {k}", within=NEAR)
        accounts = loop.report().accounts
        for name, of in NAMES.items():
            same(accounts[name], of(model), f"{name} at {k}")
        k += int(rng.choice([1, 1, 1, 30, 60])) if case["stalls"] and k % 97 == 96 else 1
