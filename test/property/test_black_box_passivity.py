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
from pmwvc_core.params.server import HuntCrossleyParams
from pmwvc_core.server.environments import LIBRARY

NETWORKS = {"network": Network, "open network": OpenNetwork}
ANY = (*NETWORKS, *sorted(name for name, record in LIBRARY.items() if record.made))
PAYING = (("corrected", "late"), ("ledger", "late"), ("ledger", "secant"))
TOLERANCE_J = 1e-9


def port(environment="wall", users=1, *, b=25.0, dof=1, contact=None, seed=0, **values):
    """A port in front of an environment, by its name or itself; all users have joined."""
    rng = np.random.default_rng(seed)
    if environment in NETWORKS:
        environment = random_network(rng, users, kind=NETWORKS[environment])
    named = isinstance(environment, str)
    params = ServerParams(
        coupling="unknown", environment=environment if named else "cube", **values
    )
    contacts = [ContactParams(**{"contact": "bilateral", **(contact or {})})] * users
    server = Users(params, contacts, b=b, axes=dof, environment=None if named else environment)
    for user in range(users):
        place = rng.normal(0.0, 0.03, dof)
        server.join(user, float(place[0]) if dof == 1 else place)
    return server


def waves(seed, server, *, size, memory, steps):
    """Random waves: from white to slow, with bursts and pauses."""
    rng, shape = np.random.default_rng(seed), (len(server.s.ports), server.axes)
    wave = np.zeros(shape)
    for _ in range(steps):
        burst = size * rng.choice([0.0, 1.0, 1.0, 10.0])
        wave = memory * wave + np.sqrt(1.0 - memory**2) * burst * rng.normal(size=shape)
        yield [float(row[0]) if server.axes == 1 else row for row in wave]


def account(server, given_waves):
    """The balance of all ports after each step.

    A delayed loop that diverges inside (K T > 2 b) ends in forces that are none; what happens in
    an environment while a damper stands in for it, only the ledger guards against.
    """
    found = []
    for wave in given_waves:
        server.step(wave)
        answers = any(not each.usable or each.jumped for each in server.s.body.users)
        faulty = answers or server.faults.steps > 0
        if faulty and server.server.compensation == "corrected":
            break
        found.append(server.taken_j)
    return np.array(found)


def assert_books_close(server):
    """What went in is where the accounts say."""
    accounts = server.energies
    names = ("environment", "late_decoding", "withheld", "contained")
    moved = 2.0 * server.came_j - server.taken_j + abs(accounts["late_decoding"])
    booked = sum(accounts[name] for name in names)
    assert booked == pytest.approx(server.taken_j, abs=1e-12 + 1e-10 * moved)


any_seed = st.integers(0, 2**32 - 1)
memories = st.sampled_from([0.0, 0.9, 0.99])


@settings(max_examples=20)
@example(  # comes in inside a soft body
    environment="hunt_crossley",
    paying=("corrected", "late"),
    exponent=1.0,
    contact={"contact_stiffness": 1.0, "contact_damping": 0.0},
    signals={"size": 0.01, "memory": 0.0},
    port_values={"b": 2.0, "period_s": 0.001, "users": 1, "dof": 1, "seed": 0},
)
@given(
    environment=st.sampled_from(ANY),
    paying=st.sampled_from(PAYING),
    exponent=st.floats(1.0, 3.0),
    contact=st.fixed_dictionaries(
        {
            "contact": st.sampled_from(["bilateral", "grip"]),
            "contact_stiffness": st.one_of(st.just(0.0), st.floats(1.0, 2e4)),
            "contact_damping": st.one_of(st.just(0.0), st.floats(0.1, 100.0)),
        }
    ),
    signals=st.fixed_dictionaries({"size": st.sampled_from([1e-2, 0.3, 2.0]), "memory": memories}),
    port_values=st.fixed_dictionaries(
        {
            "b": st.floats(2.0, 100.0),
            "period_s": st.sampled_from([0.001, 0.008, 0.02, 0.05]),
            "users": st.integers(1, 3),
            "dof": st.sampled_from([1, 1, 2]),
            "seed": any_seed,
        }
    ),
)
def test_no_environment_gives_out_more_than_it_got(
    environment, paying, exponent, contact, signals, port_values
):
    """Random networks, and those of the library; an active one is held by the ledger."""
    compensation, decoding = paying if environment != "active_wall" else PAYING[1]
    law = HuntCrossleyParams(exponent=exponent)
    server = port(
        environment,
        contact=contact,
        compensation=compensation,
        decoding=decoding,
        hunt_crossley=law,
        **port_values,
    )
    found = account(server, waves(port_values["seed"] + 1, server, steps=80, **signals))
    assert found.min() >= -TOLERANCE_J
    assert_books_close(server)


@pytest.mark.parametrize("environment", ["network", "wall", "cube", "active_wall"])
@pytest.mark.parametrize("compensation", ["none", "printed"])
def test_untreated_and_as_published_some_of_them_give_out_more(environment, compensation):
    """The same balance, the same waves: the test above is able to fail."""
    stiff = {"contact_stiffness": 5000.0}
    values = {"compensation": compensation, "period_s": 0.02, "decoding": "late"}
    server = port(environment, 2, contact=stiff, seed=5, **values)
    found = account(server, waves(5, server, size=0.3, memory=0.0, steps=300))
    assert found.min() < -1e-3
    assert_books_close(server)


def test_as_published_a_port_that_is_passive_untreated_injects_joules():
    """App. C section 6: 500 N/m, no damping, b = 25, 20 ms: K T + 2 B < b. White waves, 20 s."""
    left, spring = {}, {"contact_stiffness": 500.0, "contact_damping": 0.0}
    white = np.random.default_rng(0).normal(size=(1000, 1)).tolist()
    for compensation in ("none", "printed", "corrected", "ledger"):
        values = {"compensation": compensation, "decoding": "late", "period_s": 0.02}
        left[compensation] = account(port(contact=spring, **values), white)
    assert left["none"].min() >= 0.0
    assert left["printed"][-1] < -2.1
    assert left["corrected"][-1] > left["none"][-1]  # takes more than it need
    np.testing.assert_allclose(left["ledger"], left["none"], rtol=1e-12, atol=1e-12)


@settings(max_examples=20)
@example(b=5.0, share=0.6, fill=0.875, decoding="secant", memory=0.9, seed=25)  # first it trembled
@given(
    b=st.floats(5.0, 100.0),
    share=st.sampled_from([0.0, 0.3, 0.6, 1.0]),
    fill=st.floats(0.01, 1.0),
    decoding=st.sampled_from(["secant", "late"]),
    memory=memories,
    seed=any_seed,
)
def test_the_ledger_leaves_a_wall_alone_that_is_passive_untreated(
    b, share, fill, decoding, memory, seed
):
    """K h + 2 B <= b. Decoded late a spring or a damper gives back all; both together, or while a
    slope is learned, all but little.
    """
    contact = {
        "contact_stiffness": share * fill * b / ServerParams().period_s,
        "contact_damping": 0.5 * (1.0 - share) * fill * b,
    }
    server = port(b=b, contact=contact, decoding=decoding, seed=seed)
    account(server, waves(seed, server, size=0.3, memory=memory, steps=200))
    allowed = 1e-12 if share in (0.0, 1.0) and decoding == "late" else 0.05
    assert server.energies["withheld"] <= allowed * server.came_j


@settings(max_examples=20)
@given(
    allowance_w=st.sampled_from([0.0, 0.02, 0.5]),
    allowance_j=st.sampled_from([0.0, 0.05, 1.0]),
    users=st.integers(1, 3),
    force=st.floats(-5.0, 5.0),
    seed=any_seed,
)
def test_an_active_environment_gives_no_more_than_its_allowance(
    allowance_w, allowance_j, users, force, seed
):
    allowances = {"allowance_w": allowance_w, "allowance_j": allowance_j}
    server = port(Pusher(force), users, seed=seed, **allowances)
    found = account(server, waves(seed, server, size=0.1, memory=0.9, steps=150))
    allowed = np.minimum(allowance_w * server.server.period_s * np.arange(1, 151), allowance_j)
    assert np.all(found >= -allowed - TOLERANCE_J)
    assert server.energies["granted"] <= allowed[-1] + 1e-12
    assert_books_close(server)


def test_an_active_environment_uses_its_allowance_up_and_then_is_held():
    server = port(Pusher(-2.0), allowance_w=0.05, allowance_j=0.02)
    found = account(server, [[0.0]] * 200)
    assert np.all(found[49:] == pytest.approx(-0.02))  # 50 mW for 0.4 s
    assert server.energies["granted"] == pytest.approx(0.02)
    assert server.energies["withheld"] > 0.2
    for free in ("none", "corrected"):  # the control: nothing holds it there
        assert account(port(Pusher(-2.0), compensation=free), [[0.0]] * 200)[-1] < -0.1


@pytest.mark.parametrize("cap", [0.0, 0.25])
def test_energy_saved_for_long_is_not_let_loose_at_once(cap):
    server = port(Pusher(-50.0, rest=2000), tank_cap_j=cap)
    saved = account(server, [[1.0]] * 2000)[-1]
    assert saved > 2.0
    account(server, [[0.0]] * 100)
    assert server.energies["tank"] == pytest.approx(0.0, abs=1e-12)
    assert saved - server.taken_j == pytest.approx(cap)


@pytest.mark.parametrize("kind", NETWORKS.values())
def test_energy_goes_in_at_one_user_and_out_at_the_other(kind):
    across = 400.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    server = port(kind(2, [], stiffness=across, damping=0.0 * across), 2)
    push = np.sin(2.0 * np.pi * 0.5 * 0.008 * np.arange(1000))
    found = account(server, [[float(wave), 0.0] for wave in push])
    first, second = (each.u_j - each.v_j for each in server.s.ports)
    assert found.min() >= -TOLERANCE_J
    assert second < -0.5 * first < 0.0  # most of it is with the second user now
    assert server.energies["withheld"] <= 1e-9
