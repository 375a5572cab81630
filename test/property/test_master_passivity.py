# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The master's port emits no more energy than it receives, whatever is made of its force: behind a
number or a matrix, alone or with a filter bank or a velocity filter in its waves.
"""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.law_rigs import ForceLimits
from support.port_rig import Port
from support.strategies import behind, matrices

from pmwvc_core.ends.inbox import value
from pmwvc_core.params import BankParams, FilterParams, VelocityFilterParams

TICK_S = 0.001
M = 8
impedances = st.floats(0.5, 200.0)
numbers_of_axes = st.integers(1, 3)
seeds = st.integers(0, 2**32 - 1)
limits = st.fixed_dictionaries(
    {
        "max_force": st.floats(0.05, 20.0),
        "max_slew": st.floats(1.0, 20000.0),
        "soft_start_s": st.floats(0.01, 0.2),
        "damper_velocity": st.floats(0.1, 1.0),
        "fault_velocity": st.floats(1.1, 3.0),
    }
)


def master(impedance=25.0, *, kind="none", **parts):
    return behind(impedance, rate_drop=M, filter=FilterParams(kind=kind), **parts)


class Account:
    """The port's energy account: what it got less what it emitted, from its signals alone."""

    def __init__(self, params, *, axes=1):
        self.params, self.axes, self.port = params, axes, Port(params, axes=axes)
        self.balance = 0.0
        self.unpaid = 0.0  # as balance, had the wave not been shortened

    def tick(self, xd, change):
        """Run a tick in which ``change`` makes the force applied from the force asked for."""
        port = self.port
        asked = port.step(xd, xd)
        natural = port.u_m
        applied = change(asked)
        port.applied(applied)
        got = np.dot(port.v_m, port.v_m) / 2 + np.dot(applied, xd)
        self.balance += TICK_S * (got - np.dot(port.u_m, port.u_m) / 2)
        self.unpaid += TICK_S * (got - np.dot(natural, natural) / 2)
        return natural, applied

    def limited(self, xd, safety, silence_s=0.0):
        """Run a tick with these limits; return the force applied."""
        return self.tick(xd, lambda asked: safety(asked, xd, x=xd, silence_s=silence_s))[1]

    @property
    def deficit_j(self):
        return self.port.s.deficit_j

    @property
    def tolerance(self):
        """Rounding: of a matrix, of sums of filters and of plain sums."""
        s = self.port.s
        exact = not (self.params.impedance_matrix or self.params.bank.kind != "none")
        return (1e-12 if exact else 1e-10) * (1.0 + s.v_m_j + s.u_m_j)


def draw(axes, rng, scale):
    return value(tuple(rng.normal(0.0, scale, axes).tolist()))


PORTS = {
    "number": impedances.map(master),
    "matrix": matrices().map(master),
    "exact velocity filter": st.just(
        master(kind="first_order", velocity_filter=VelocityFilterParams(kind="exact"))
    ),
    "complementary velocity filter": st.just(
        master(kind="first_order", velocity_filter=VelocityFilterParams(kind="complementary"))
    ),
    "complementary bank": st.just(master(bank=BankParams(kind="complementary"))),
    "dissertation's bank": st.just(master(bank=BankParams(kind="dissertation"))),
}
CHANGES = {
    "untouched": lambda rng, asked, force: asked + 0.0,
    "smaller": lambda rng, asked, force: rng.uniform(0.0, 1.0) * asked,
    "any": lambda rng, asked, force: draw(np.size(asked), rng, force),
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("port", PORTS)
@settings(max_examples=12)
@given(st.data(), numbers_of_axes, seeds, st.floats(0.01, 30.0))
def test_whatever_is_made_of_its_force_is_paid_for(port, change, data, axes, seed, force):
    """At every tick: emitted <= received, but for what the force itself gave away (the debt). A
    force that is made smaller gives nothing away; an untouched one leaves the wave bit for bit.
    """
    params, rng = data.draw(PORTS[port]), np.random.default_rng(seed)
    axes = params.impedance_matrix.count(";") + 1 if params.impedance_matrix else axes
    account = Account(params, axes=axes)
    for tick in range(60):
        if tick % M == 0:
            account.port.receive(draw(axes, rng, 1.0))
        natural, _ = account.tick(
            draw(axes, rng, 0.3), lambda asked: CHANGES[change](rng, asked, force)
        )
        assert account.balance + account.deficit_j >= -account.tolerance
        assert account.deficit_j >= 0.0
        if change != "any":
            assert account.deficit_j <= account.tolerance
        if change == "untouched":
            assert np.all(account.port.u_m == natural)
            assert abs(account.balance) <= account.tolerance


def test_control_without_shortening_a_smaller_force_creates_energy():
    account = Account(master())
    for _ in range(100):
        account.port.receive(0.0)
        account.tick(0.2, lambda asked: 0.5 * asked)
    assert account.balance >= -1e-15
    assert account.unpaid < -0.04  # half of b xd^2 over 0.1 s


@settings(max_examples=20)
@given(
    impedances,
    numbers_of_axes,
    seeds,
    limits,
    st.lists(st.tuples(st.integers(1, 80), st.integers(1, 80)), min_size=1, max_size=4),
    st.sampled_from([0.05, 0.5, 2.0]),
    st.booleans(),
)
def test_limits_and_stalls_are_paid_for_and_make_no_step(
    impedance, axes, seed, params, stalls, speed, changes
):
    """Silence and answers in turn, from a tick to far beyond the time the force fades in; with an
    impedance that ``changes`` over its whole range while it runs.
    """
    account, rng = Account(master(impedance), axes=axes), np.random.default_rng(seed)
    safety = ForceLimits(axes=axes, **params)
    quiet = [t for there, gone in stalls for t in [0] * there + list(range(25, 25 + gone))]
    xd, before = draw(axes, rng, speed), 0.0
    for tick, silent_ticks in enumerate(quiet):
        if tick % M == 0 and not silent_ticks:
            if changes:
                wanted = float(10.0 ** rng.uniform(-2.0, 3.0))
                account.port.configure(dataclasses.replace(account.params, impedance=wanted))
            account.port.receive(draw(axes, rng, 1.0))
        xd = 0.97 * xd + 0.2 * draw(axes, rng, speed)
        force = account.limited(xd, safety, silent_ticks * TICK_S)
        assert account.balance + account.deficit_j >= -account.tolerance
        change = np.linalg.norm(force - before)
        assert change <= params["max_slew"] * TICK_S * (1 + 1e-9) + 1e-12
        before = force


def test_a_debt_is_kept_back_from_later_waves():
    account = Account(master())
    account.port.receive(0.0)
    account.tick(-0.2, lambda asked: 3.0)  # an old force pushes along: 0.6 W given away
    assert account.deficit_j > 0.0 and account.port.u_m == 0.0
    ticks = 0
    while account.deficit_j > 0.0:
        account.tick(0.1, lambda asked: asked)  # the hand puts 0.25 W in
        ticks += 1
    assert ticks == 3
    account.tick(0.1, lambda asked: asked)
    assert account.balance >= -1e-15
    assert account.port.u_m == np.sqrt(50.0) * 0.1


@settings(max_examples=20)
@given(impedances, seeds, limits, st.sampled_from(["zoh", "foh"]))
def test_packets_carry_no_more_than_packets_and_hand_brought(impedance, seed, params, hold):
    """From packet to packet, with integrate-and-dump, at every frame end."""
    account = Account(master(impedance, kind="integrate_and_dump", hold=hold))
    safety = ForceLimits(**params)
    port, rng, taken = account.port, np.random.default_rng(seed), 0.0
    xd = came = 0.0
    for _ in range(60):
        port.send()
        brought = port.s.v_rx_j + taken + account.deficit_j
        assert port.s.u_tx_j <= brought + account.tolerance
        port.receive(wave := float(rng.normal(0.0, 1.0)))
        came += wave**2 * M * TICK_S / 2
        assert port.s.v_rx_j == pytest.approx(came)
        for _ in range(M):
            xd = 0.97 * xd + float(rng.normal(0.0, 0.05))
            f = account.limited(xd, safety)
            taken += TICK_S * f * xd
