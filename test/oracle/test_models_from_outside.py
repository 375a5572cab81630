# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact model of code from another package does what the simulator does, or there is none."""

import dataclasses
import math
from typing import NamedTuple

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracle.test_multirate_model import bounded, compare, scenarios
from support import linear_loops
from support.lab import offer, source_of

from pmwvc_analysis.models import stability
from pmwvc_analysis.models.any_delay import any_delay
from pmwvc_analysis.models.linear import NonlinearError
from pmwvc_analysis.models.linearize import build, spectral_radius
from pmwvc_analysis.prediction import text as prediction_text
from pmwvc_core import plugins
from pmwvc_core.controllers import library
from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.controllers.plugged import DeviceAnswer
from pmwvc_core.law.server import contacts
from pmwvc_core.law.server.contacts import couple
from pmwvc_core.law.server.coupling import OneStepDelay
from pmwvc_core.law.vectors import minus, plus, scaled
from pmwvc_core.server.couplings import COUPLINGS

B = 25.0  # N s/m, as the scenarios have it


class Kept(NamedTuple):
    """The wave that acts, and the one before it."""

    v: tuple
    before: tuple


def waves(received):
    """Return the device's law of a controller with waves, which takes a wave as ``received``."""

    def device(s, tick, p):
        if tick.answered:
            s = received(s, tick.packet.wave)
        u = minus(scaled(tick.xd, math.sqrt(2.0 * B)), s.v)
        force = minus(scaled(tick.xd, B), scaled(s.v, math.sqrt(2.0 * B)))
        return s, DeviceAnswer(force, u)

    return device


def soft(s, wave):
    """Take the mean of the last two waves."""
    return Kept(scaled(plus(wave, s.before), 0.5), wave)


LEAK = {}


def hidden(s, wave):
    """Add a wave that leaks away, which is no part of the state."""
    leak = LEAK.get("leak", scaled(wave, 0.0))
    LEAK["leak"] = plus(scaled(leak, 0.5), scaled(wave, 0.1))
    return s._replace(v=plus(wave, leak))


def dead(s, wave):
    """Take no wave under a milliwatt."""
    return s._replace(v=wave if abs(wave[0]) > 1e-3 else scaled(wave, 0.0))


def branching(s, wave):
    """Take less of a wave of one sign."""
    return s._replace(v=wave if wave[0] > 0.0 else scaled(wave, 0.5))


ENDS = {law.__name__: law for law in (soft, hidden, dead, branching)}
MEANS = {}


class Remembering(NamedTuple):
    """Decodes with a mean of forces that it keeps for itself."""

    none: int = 0


class Failing(NamedTuple):
    """Fails in every step."""

    none: int = 0


@couple.member(Remembering)
def remembering(p, avatars, body, law):
    softer = []
    for index, a in enumerate(avatars):
        before = MEANS.get(index, scaled(a.f, 0.0))
        MEANS[index] = scaled(plus(before, a.f), 0.5)
        softer.append(a._replace(f=MEANS[index]))
    return couple(OneStepDelay(0.0, law.period_s), tuple(softer), body, law)


@couple.member(Failing)
def failing(p, avatars, body, law):
    raise ZeroDivisionError("no mass")


class ByModule(NamedTuple):
    """Avatars that stand where they are; moved by a function of a module of the library."""

    h: float


@couple.member(ByModule)
def by_module(p, avatars, body, law):
    after, body, lost_j, settled = couple(OneStepDelay(0.0, p.h), avatars, body, law)
    moved = []
    for a in after:
        contact, more_j = contacts.slid(a.contact, scaled(a.f, -1e-6))
        moved.append(a._replace(contact=contact))
        lost_j += more_j
    return tuple(moved), body, lost_j, settled


def controller(name):
    return dataclasses.replace(
        LIBRARY["pmwvc"],
        name=name,
        linear=name,
        words=ENDS[name].__doc__,
        device=waves(ENDS[name]),
        device_rest=lambda p, axes: Kept((0.0,) * axes, (0.0,) * axes),
    )


def coupling(name, law):
    return dataclasses.replace(
        COUPLINGS.library["one_step_delay"], name=name, linear=name, law=law
    )


@pytest.fixture(scope="module", autouse=True)
def lab():
    """The examples of the documentation, and ends whose models would be wrong."""
    examples = {"__name__": "lab_examples"}
    for page in ("controllers.md", "couplings.md"):
        exec(source_of(page)[1], examples)
    group, couplings = library.RECORDS.plugins.group, COUPLINGS.plugins.group
    own = {
        "averaged": examples["AVERAGED"],
        "remembering": coupling("remembering", lambda old_s, new_s: Remembering()),
        "failing": coupling("failing", lambda old_s, new_s: Failing()),
        "by_module": coupling("by_module", lambda old_s, new_s: ByModule(old_s + new_s)),
    }
    with pytest.MonkeyPatch.context() as patch:
        points = offer(patch, group, "lab_ends", {name: controller(name) for name in ENDS})
        offer(patch, couplings, "lab_couplings", own, kept=points)
        plugins.imported.cache_clear()
        yield
    plugins.imported.cache_clear()


@pytest.fixture(autouse=True)
def forgotten():
    LEAK.clear()
    MEANS.clear()


def with_(scenario, *, controller="pmwvc", coupling=None):
    """Return a scenario with parts of the lab."""
    server = dataclasses.replace(scenario.server, coupling=coupling or scenario.server.coupling)
    return dataclasses.replace(scenario, controller=controller, server=server)


@settings(max_examples=8, deadline=None)
@given(scenarios(), st.sampled_from([{"controller": "soft"}, {"coupling": "averaged"}]))
def test_the_model_of_code_from_outside_does_what_the_simulator_does(scenario, parts):
    black_box = scenario.coupling.black_box and "coupling" in parts
    assume(scenario.controller == "pmwvc" and not black_box)
    other = with_(scenario, **parts)
    model = build(other)
    assume(bounded(model))
    assert compare(other, model=model) < 1e-9


def test_a_coupling_is_tried_where_the_impedance_follows_contact():
    given = {"channel": "strict", "link__delay_s": 0.008, "server__coupling": "averaged"}
    stiff = build(linear_loops.scenario(**given, master__impedance=20.0))
    follows = linear_loops.scenario(**given, master__impedance=5.0, master__contact_impedance=20.0)
    assert spectral_radius(build(follows)) == pytest.approx(spectral_radius(stiff))


def test_the_models_are_their_own_and_not_those_of_the_library():
    own = linear_loops.scenario(link__delay_s=0.008, server__coupling="one_step_delay")
    for other in (with_(own, controller="soft"), with_(own, coupling="averaged")):
        assert compare(other, model=build(own)) > 1e-3


@pytest.mark.parametrize(
    ("part", "name", "reason"),
    [
        ("controller", "hidden", "superposition does not hold for user1"),
        ("controller", "dead", "superposition does not hold for user1"),
        ("controller", "branching", "superposition does not hold for user1"),
        ("coupling", "remembering", "superposition does not hold for server"),
        ("coupling", "failing", "coupling = failing: not perturbed: ZeroDivisionError: no mass"),
    ],
)
def test_what_would_have_a_wrong_model_has_none(part, name, reason):
    scenario = with_(linear_loops.scenario(link__delay_s=0.008), **{part: name})
    with pytest.raises(NonlinearError, match=reason):
        stability.radii(scenario)
    assert not any("Stable:" in line for line in prediction_text.lines(scenario, live=False))


def test_a_law_may_name_the_modules_of_the_library():
    scenario = with_(linear_loops.scenario(link__delay_s=0.008), coupling="by_module")
    assert compare(scenario) < 1e-9


def test_nothing_is_proved_of_code_from_another_package():
    proved = {"master__impedance": 22.87, "master__filter__cutoff_hz": 12.5}
    own = linear_loops.scenario(master__filter__pole_rad_s=None, **proved)
    assert any_delay(own).proved
    assert any_delay(with_(own, controller="soft")) is None
    averaged = any_delay(with_(own, coupling="averaged"))
    assert not averaged.proved
    assert "no bound is known for the server's coupling" in averaged.reasons
