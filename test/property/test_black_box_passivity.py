# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A wave port in front of an environment it knows nothing of: what comes out, and what went in."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from support.law_rigs import Users
from support.passive_networks import Network, OpenNetwork, Pusher, random_network

from pmwvc_core.params import ContactParams, ServerParams
from pmwvc_core.params.server import DECODINGS, HuntCrossleyParams
from pmwvc_core.server.environments import LIBRARY

PASSIVE_LIBRARY = sorted(set(LIBRARY) - {"active_wall"})
PAYING = (("corrected", "late"), ("ledger", "late"), ("ledger", "secant"))
TOLERANCE_J = 1e-9


def port(environment, users, *, b=25.0, dof=1, **values):
    """A port in front of an environment object."""
    params = ServerParams(coupling="unknown", **values)
    contacts = [ContactParams(contact="bilateral")] * users
    return Users(params, contacts, b=b, axes=dof, environment=environment)


def waves(rng, users, dof, *, size, memory, steps):
    """Random waves: from white to slow, with bursts and pauses."""
    wave = np.zeros((users, dof))
    for _ in range(steps):
        burst = size * rng.choice([0.0, 1.0, 1.0, 10.0])
        wave = memory * wave + np.sqrt(1.0 - memory**2) * burst * rng.normal(size=(users, dof))
        yield [float(row[0]) if dof == 1 else row for row in wave]


def join_all(server, rng, dof):
    for user in range(len(server.s.ports)):
        place = rng.normal(0.0, 0.03, dof)
        server.join(user, float(place[0]) if dof == 1 else place)


def faulty(server):
    """Whether a force could not be used."""
    answers = any(not each.usable or each.jumped for each in server.s.body.users)
    return answers or server.faults.steps > 0


def account(server, given_waves):
    """The balance of all ports after each step.

    A delayed loop that diverges inside (K T > 2 b) ends in forces that are none; what happens in
    an environment while a damper stands in for it, only the ledger guards against.
    """
    found = []
    for wave in given_waves:
        server.step(wave)
        if faulty(server) and server.server.compensation == "corrected":
            break
        found.append(server.taken_j)
    return np.array(found)


def books_close(server):
    """What went in is where the accounts say."""
    accounts = server.energies
    names = ("environment", "late_decoding", "withheld", "contained")
    booked = sum(accounts[name] for name in names)
    moved = 2.0 * server.came_j - server.taken_j + abs(accounts["late_decoding"])
    return booked == pytest.approx(server.taken_j, abs=1e-12 + 1e-10 * moved)


draws = {
    "impedance": st.floats(2.0, 100.0),
    "period_s": st.sampled_from([0.001, 0.008, 0.02, 0.05]),
    "size": st.sampled_from([1e-2, 0.3, 2.0]),
    "memory": st.sampled_from([0.0, 0.9, 0.99]),
    "users": st.integers(1, 3),
    "dof": st.sampled_from([1, 1, 2]),
    "seed": st.integers(0, 2**32 - 1),
}


@settings(max_examples=25)
@given(paying=st.sampled_from(PAYING), kind=st.sampled_from([Network, OpenNetwork]), **draws)
def test_a_random_passive_network_gives_out_no_more_than_it_got(
    paying, kind, impedance, period_s, size, memory, users, dof, seed
):
    compensation, decoding = paying
    rng = np.random.default_rng(seed)
    server = port(
        random_network(rng, users, kind=kind),
        users,
        b=impedance,
        dof=dof,
        compensation=compensation,
        decoding=decoding,
        period_s=period_s,
    )
    join_all(server, rng, dof)
    found = account(server, waves(rng, users, dof, size=size, memory=memory, steps=80))
    assert found.min() >= -TOLERANCE_J
    assert books_close(server)


library = {
    "contact": st.sampled_from(["bilateral", "grip"]),
    "stiffness": st.one_of(st.just(0.0), st.floats(1.0, 2e4)),
    "damping": st.one_of(st.just(0.0), st.floats(0.1, 100.0)),
}


@settings(max_examples=40)
@example(  # comes in inside a soft body
    paying=("corrected", "late"),
    environment="hunt_crossley",
    exponent=1.0,
    contact="bilateral",
    stiffness=1.0,
    damping=0.0,
    impedance=2.0,
    period_s=0.001,
    size=0.01,
    memory=0.0,
    users=1,
    dof=1,
    seed=0,
)
@given(
    paying=st.sampled_from(PAYING),
    environment=st.sampled_from(PASSIVE_LIBRARY),
    exponent=st.floats(1.0, 3.0),
    **library,
    **draws,
)
def test_every_passive_environment_of_the_library_gives_out_no_more_than_it_got(
    paying,
    environment,
    exponent,
    contact,
    stiffness,
    damping,
    impedance,
    period_s,
    size,
    memory,
    users,
    dof,
    seed,
):
    rng = np.random.default_rng(seed)
    params = ServerParams(
        coupling="unknown",
        environment=environment,
        compensation=paying[0],
        decoding=paying[1],
        period_s=period_s,
        hunt_crossley=HuntCrossleyParams(exponent=exponent),
    )
    contacts = ContactParams(contact=contact, contact_stiffness=stiffness, contact_damping=damping)
    server = Users(params, [contacts] * users, b=impedance, axes=dof)
    join_all(server, rng, dof)
    found = account(server, waves(rng, users, dof, size=size, memory=memory, steps=80))
    assert found.min() >= -TOLERANCE_J
    assert books_close(server)


@pytest.mark.parametrize("compensation", ["none", "printed"])
def test_untreated_and_as_published_some_of_them_give_out_more(compensation):
    """The same balance, the same waves: the test above is able to fail."""
    worst = {}
    for name in ("network", "wall", "cube"):
        rng = np.random.default_rng(5)
        values = {"compensation": compensation, "period_s": 0.02, "decoding": "late"}
        if name == "network":
            server = port(random_network(rng, 2), 2, **values)
        else:
            params = ServerParams(coupling="unknown", environment=name, **values)
            contacts = ContactParams(contact="bilateral", contact_stiffness=5000.0)
            server = Users(params, [contacts] * 2)
        join_all(server, rng, 1)
        found = account(server, waves(rng, 2, 1, size=0.3, memory=0.0, steps=300))
        worst[name] = found.min()
        assert books_close(server)
    assert all(least < -1e-3 for least in worst.values()), worst


def test_as_published_a_port_that_is_passive_untreated_injects_joules():
    """App. C section 6: 500 N/m, no damping, b = 25, 20 ms: K T + 2 B < b. White waves, 20 s."""
    left = {}
    for compensation in ("none", "printed", "corrected", "ledger"):
        params = ServerParams(
            coupling="unknown",
            environment="wall",
            compensation=compensation,
            decoding="late",
            period_s=0.02,
        )
        contact = ContactParams(
            contact="bilateral", contact_stiffness=500.0, contact_damping=0.0, impedance=25.0
        )
        server = Users(params, [contact])
        server.join(0, 0.0)
        white = np.random.default_rng(0).normal(size=(1000, 1)).tolist()
        left[compensation] = account(server, white)
    assert left["none"].min() >= 0.0
    assert left["printed"][-1] < -2.1
    assert left["corrected"][-1] > left["none"][-1]  # takes more than it need
    np.testing.assert_allclose(left["ledger"], left["none"], rtol=1e-12, atol=1e-12)


@settings(max_examples=25)
@given(
    b=st.floats(5.0, 100.0),
    share=st.sampled_from([0.0, 0.3, 0.6, 1.0]),
    fill=st.floats(0.01, 1.0),
    decoding=st.sampled_from(DECODINGS),
    memory=draws["memory"],
    seed=draws["seed"],
)
def test_the_ledger_leaves_a_wall_alone_that_is_passive_untreated(
    b, share, fill, decoding, memory, seed
):
    """K h + 2 B <= b. Decoded late a spring or a damper gives back all; both together, or while a
    slope is learned, all but little.
    """
    rng = np.random.default_rng(seed)
    params = ServerParams(coupling="unknown", environment="wall", decoding=decoding)
    contact = ContactParams(
        contact="bilateral",
        contact_stiffness=share * fill * b / params.period_s,
        contact_damping=0.5 * (1.0 - share) * fill * b,
    )
    server = Users(params, [contact], b=b)
    server.join(0, 0.0)
    account(server, waves(rng, 1, 1, size=0.3, memory=memory, steps=200))
    allowed = 1e-12 if share in (0.0, 1.0) and decoding == "late" else 0.05
    assert server.energies["withheld"] <= allowed * server.came_j


@settings(max_examples=20)
@given(
    allowance_w=st.sampled_from([0.0, 0.02, 0.5]),
    allowance_j=st.sampled_from([0.0, 0.05, 1.0]),
    users=draws["users"],
    force=st.floats(-5.0, 5.0),
    seed=draws["seed"],
)
def test_an_active_environment_gives_no_more_than_its_allowance(
    allowance_w, allowance_j, users, force, seed
):
    rng = np.random.default_rng(seed)
    server = port(Pusher(force), users, allowance_w=allowance_w, allowance_j=allowance_j)
    join_all(server, rng, 1)
    found = account(server, waves(rng, users, 1, size=0.1, memory=0.9, steps=150))
    time_s = server.server.period_s * np.arange(1, 151)
    allowed = np.minimum(allowance_w * time_s, allowance_j)
    assert np.all(found >= -allowed - TOLERANCE_J)
    assert server.energies["granted"] <= allowed[-1] + 1e-12
    assert books_close(server)


def test_an_active_environment_uses_its_allowance_up_and_then_is_held():
    server = port(Pusher(-2.0), 1, allowance_w=0.05, allowance_j=0.02)
    server.join(0, 0.0)
    found = account(server, [[0.0]] * 200)
    assert found[49] == pytest.approx(-0.02)  # 50 mW for 0.4 s
    assert np.all(found[49:] == pytest.approx(-0.02))
    assert server.energies["granted"] == pytest.approx(0.02)
    assert server.energies["withheld"] > 0.2
    for free in ("none", "corrected"):  # the control: nothing holds it there
        server = port(Pusher(-2.0), 1, compensation=free)
        server.join(0, 0.0)
        assert account(server, [[0.0]] * 200)[-1] < -0.1


def test_the_wall_that_moves_is_active_and_the_library_states_what_was_withheld():
    params = ServerParams(coupling="unknown", environment="active_wall")
    server = Users(params, [ContactParams()])
    server.join(0, -0.03)
    found = account(server, [[1.0 / 50.0**0.5]] * 1000)
    assert found.min() >= -TOLERANCE_J
    assert server.energies["withheld"] > 1e-3
    params = ServerParams(coupling="unknown", environment="active_wall", compensation="none")
    server = Users(params, [ContactParams()])
    server.join(0, -0.03)
    assert account(server, [[1.0 / 50.0**0.5]] * 1000).min() < -1e-3


@pytest.mark.parametrize("cap", [0.0, 0.05, 0.25])
def test_energy_saved_for_long_is_not_let_loose_at_once(cap):
    server = port(Pusher(-50.0, rest=2000), 1, tank_cap_j=cap)
    server.join(0, 0.0)
    saved = account(server, [[1.0]] * 2000)[-1]
    assert saved > 2.0
    account(server, [[0.0]] * 100)
    assert server.energies["tank"] == pytest.approx(0.0, abs=1e-12)
    assert saved - server.taken_j == pytest.approx(cap)


def test_energy_goes_in_at_one_user_and_out_at_the_other():
    across = 400.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    for kind in (Network, OpenNetwork):
        server = port(kind(2, [], stiffness=across, damping=0.0 * across), 2)
        join_all(server, np.random.default_rng(0), 1)
        push = np.sin(2.0 * np.pi * 0.5 * 0.008 * np.arange(1000))
        found = account(server, [[float(wave), 0.0] for wave in push])
        first, second = (each.u_j - each.v_j for each in server.s.ports)
        assert found.min() >= -TOLERANCE_J
        assert second < -0.5 * first < 0.0  # most of it is with the second user now
        assert server.energies["withheld"] <= 1e-9
