# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""When decoding along a slope is passive at a wall, and what the prediction says of it.

The port power (docs/theory.md 5.14) is concave in y = |z - 1|^2, so it is non-negative on [0, 4]
exactly if it is at both ends: y = 0 gives the second condition of the rule, y = 4 the first. Where
both hold strictly, W + F/b never vanishes, so no pole leaves the unit circle as a wall stiffens.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import plain as scenarios
from support.law_rigs import Users
from support.laws import in_bulk

from pmwvc_analysis.prediction.environment import rule
from pmwvc_core.law.black_box import secant
from pmwvc_core.law.black_box.secant import REPAID, ExpectedForce, decoded
from pmwvc_core.law.wave.wave import free_velocity, impedance, wave_v
from pmwvc_core.params import ContactParams, ServerParams

PERIOD_S = 0.02


def responds(k, damping, b, slope, *, repaid=REPAID, steps=4096):
    """Return the impulse responses v of ports to a wall, decoded with a given G (one axis) and
    repaying; parameters ``(ports,)``, result ``(steps, ports)``.
    """
    found = np.zeros((len(b), steps))
    for row, values in zip(found, zip(k, damping, b, slope, strict=True), strict=True):
        RESPOND(*map(float, values), repaid, row)
    return found.T


def respond(k, damping, b, slope, repaid, found):
    """Write the impulse response of one port."""
    port, x, force, undelivered, apart = impedance(b), 0.0, 0.0, 0.0, (0.0,)
    for n in range(len(found)):
        u = 1.0 if n == 0 else 0.0
        free = free_velocity(port, (u,))[0] + undelivered * (repaid / PERIOD_S)
        (xd,), _ = decoded(ExpectedForce((force,), ((slope,),), apart), port, (free,))
        x += PERIOD_S * xd
        force = k * x + damping * xd
        v = wave_v(port, (u,), (force,))[0]
        undelivered += PERIOD_S * (0.5 * free_velocity(port, (u + v,))[0] - xd)
        found[n] = v


RESPOND = in_bulk(respond)


def gives_out_more(responses):
    """Tell of each port whether some wave comes back with more energy than it brought."""
    with np.errstate(over="ignore", invalid="ignore"):
        peaks = np.abs(np.fft.rfft(responses, axis=0)).max(axis=0)
        # Where it has not died out, the port rings by itself.
        return ~((np.abs(responses[-1]) <= 1e-6) & (peaks <= 1.0 + 1e-9))


def margin(b, stiff, viscous, slope, repaid=REPAID):
    """Return by how much both conditions on G hold, over b."""
    stiffest = 1.0 - 0.5 * repaid + slope - stiff - 2.0 * viscous
    steepest = repaid * (0.5 + viscous / stiff) + stiff - slope
    return np.minimum(stiffest, steepest) if repaid else stiffest


def active(b, stiff, viscous, slope, repaid=REPAID):
    """Tell of each port, relative to b, whether it gives out more than it gets."""
    responses = responds(stiff * b / PERIOD_S, viscous * b, b, slope * b, repaid=repaid)
    return gives_out_more(responses)


ports = st.tuples(  # b, K T / b, B / b and G / b; not too near the edge of the rule
    st.floats(2.0, 80.0), st.floats(0.02, 6.0), st.floats(0.01, 2.0), st.floats(0.0, 6.0)
).filter(lambda values: abs(margin(*values)) > 0.02 and abs(margin(*values, 0.0)) > 0.02)


@pytest.mark.parametrize("repaid", [0.0, REPAID])
@settings(max_examples=12)
@given(st.lists(ports, min_size=1, max_size=40))
def test_it_is_passive_if_and_only_if_both_conditions_on_g_hold(repaid, drawn):
    """Second route: the reflection of the loop as it runs, at every frequency."""
    values = np.array(drawn).T
    np.testing.assert_array_equal(active(*values, repaid), margin(*values, repaid) < 0.0)


def test_without_g_or_without_the_repayment_the_rule_would_be_wrong():
    """The controls: ports that such a rule takes for active are passive, or the other way."""
    rng = np.random.default_rng(3)
    stiff, viscous, ratio = rng.uniform((0.1, 0.05, 0.8), (4.0, 0.6, 1.4), (60, 3)).T
    slope = ratio * stiff
    found = active(np.full(60, 25.0), stiff, viscous, slope)
    assert np.sum(found != (stiff + 2.0 * viscous > 1.0)) > 10
    assert np.sum(found & (margin(25.0, stiff, viscous, slope, 0.0) > 0.0)) > 10


def power(stiff, viscous, slope, y, repaid=REPAID):
    """Return |z - 1 + r|^2 Re(W F*)/(b |xd|^2), y = |z - 1|^2. docs/theory.md 5.14"""
    both = viscous * (viscous + stiff)
    return (
        (viscous + 0.5 * stiff) * (repaid**2 + (1.0 - repaid) * y)
        - 0.5 * both * y**2
        + repaid * viscous**2 * y
        + (1.0 + 0.5 * repaid) * viscous * stiff * y
        + (slope - stiff) * ((1.0 - 0.5 * repaid) * viscous * y + 0.5 * stiff * y - repaid * stiff)
    )


@pytest.mark.parametrize("repaid", [0.0, REPAID, 0.9])
def test_the_power_of_the_proof_is_that_of_the_loop(repaid):
    rng = np.random.default_rng(2)
    stiff = rng.uniform(0.3, 4.0, 30)
    viscous, slope = rng.uniform(0.05, 0.3, 30), stiff * rng.uniform(0.95, 1.02, 30)
    b = np.full(30, 25.0)
    responses = responds(stiff * b / PERIOD_S, viscous * b, b, slope * b, repaid=repaid)
    found = np.fft.rfft(responses, axis=0)[1:]
    z = np.exp(2j * np.pi * np.arange(1, len(found) + 1) / len(responses))[:, None]
    speed = (1.0 - found) / np.sqrt(2.0) / (viscous + stiff / (1.0 - 1.0 / z))
    w, force = (1.0 + found) / np.sqrt(2.0), (1.0 - found) / np.sqrt(2.0)
    measured = np.abs(z - 1.0 + repaid) ** 2 * np.real(w * np.conj(force)) / np.abs(speed) ** 2
    expected = power(stiff, viscous, slope, np.abs(z - 1.0) ** 2, repaid)
    np.testing.assert_allclose(measured, expected, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("repaid", [0.0, REPAID])
def test_the_running_port_responds_like_that(monkeypatch, repaid):
    """With a slope that stays, no compensation and a wall that holds on both sides."""
    monkeypatch.setattr(secant, "REPAID", repaid)
    monkeypatch.setattr(secant, "DECAY", 1.0)
    monkeypatch.setattr(secant, "_raised", lambda slope, *_: slope)
    k, damping, b = 3000.0, 8.0, 25.0
    params = ServerParams(
        coupling="unknown", environment="wall", period_s=PERIOD_S, compensation="none"
    )
    contact = ContactParams(contact="bilateral", contact_stiffness=k, contact_damping=damping)
    server = Users(params, [contact], b=b)
    server.join(0, 0.0)
    server.step([1e-12])  # a line needs a force to begin with
    (user,) = server.s.body.users
    known = user._replace(secant=user.secant._replace(slope=((k,),)))
    server.s = server.s._replace(body=server.s.body._replace(users=(known,)))
    found = [server.step([1.0 if n == 0 else 0.0])[0] for n in range(60)]
    expected = responds(*np.array([[k], [damping], [b], [k * PERIOD_S]]), repaid=repaid, steps=60)
    np.testing.assert_allclose(found, expected[:, 0], atol=1e-9)


@pytest.mark.parametrize("decoding", ["secant", "late"])
def test_the_prediction_calls_a_port_limited_where_the_loop_gives_out_more(decoding):
    rng = np.random.default_rng(5)
    told, values = [], []
    while len(told) < 40:
        stiff, viscous = rng.uniform((0.05, 0.3), (4.0, 0.6))
        texts = [
            f"server.contact_stiffness={stiff * 25.0 / PERIOD_S}",
            f"server.contact_damping={viscous * 25.0}",
            f"server.decoding={decoding}",
        ]
        scenario = scenarios.load("wall_slow", settings_texts=texts)
        found = rule(scenario.users[0], scenario)
        slope = found.slope / 25.0
        repaid = REPAID if decoding == "secant" else 0.0
        if abs(margin(25.0, stiff, viscous, slope, repaid)) > 0.02:
            told.append(found.met)
            values.append((25.0, stiff, viscous, slope))
    assert 5 < sum(told) < 35 or decoding == "late"
    np.testing.assert_array_equal(~active(*np.array(values).T, repaid), told)
