# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact model of code from another package does what the simulator does, or there is none."""

import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracle.test_multirate_model import bounded, compare, scenarios
from support import linear_loops
from support.lab import offer, source_of

from pmwvc_analysis.delays.any_delay import any_delay
from pmwvc_analysis.models import stability
from pmwvc_analysis.models.hyperperiod import Hyperperiod
from pmwvc_analysis.models.linear import AMPLITUDE, STRICT_AMPLITUDE, NonlinearError
from pmwvc_analysis.models.multirate import build, spectral_radius
from pmwvc_analysis.models.outside import trial
from pmwvc_analysis.prediction import text as prediction_text
from pmwvc_core import plugins
from pmwvc_core.controllers import library
from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.master.port import WaveMaster
from pmwvc_core.server.couplings import COUPLINGS
from pmwvc_core.server.couplings.one_step_delay import OneStepDelay


class Hidden(WaveMaster):
    """Adds a wave that leaks away, which it does not declare."""

    leak = 0.0

    def receive(self, wave):
        super().receive(wave + self.leak)
        self.leak = 0.5 * self.leak + 0.1 * wave


class Enclosed(WaveMaster):
    """The same, in a closure."""

    def __init__(self, params):
        super().__init__(params)
        kept = [0.0]

        def receive(wave):
            WaveMaster.receive(self, wave + kept[0])
            kept[0] = 0.5 * kept[0] + 0.1 * wave

        self.receive = receive


class Dead(WaveMaster):
    """Takes no wave under a milliwatt."""

    def receive(self, wave):
        super().receive(np.where(np.abs(wave) < 1e-3, 0.0, wave))


class Clipped(WaveMaster):
    """Takes no wave above a milliwatt."""

    def receive(self, wave):
        super().receive(np.clip(wave, -1e-3, 1e-3))


class Fading(WaveMaster):
    """Takes less of every wave than of the one before."""

    MEMORY = "gain"

    def __init__(self, params):
        super().__init__(params)
        self.gain = 1.0

    def receive(self, wave):
        self.gain *= 0.99
        super().receive(self.gain * wave)


class Undeclared:
    """A whole end that declares nothing."""

    def __init__(self, params):
        self.__dict__["inner"] = WaveMaster(params)

    def __getattr__(self, name):
        return getattr(self.inner, name)

    def __setattr__(self, name, value):
        setattr(self.inner, name, value)


class Remembering(OneStepDelay):
    """Decodes with a mean of forces that it keeps for itself."""

    def __init__(self, params):
        super().__init__(params)
        self.means = {}

    def step(self, ports, body):
        for index, port in enumerate(ports):
            self.means[index] = 0.5 * self.means.get(index, 0.0) + 0.5 * port.f_s
            port.f_s = self.means[index]
        return super().step(ports, body)


class Branching(WaveMaster):
    """Asks for the sign of a wave as if it were one number."""

    def receive(self, wave):
        super().receive(wave if wave > 0.0 else 0.5 * wave)


class Failing(OneStepDelay):
    """Fails in every step."""

    def step(self, ports, body):
        raise ZeroDivisionError("no mass")


class Ordered(OneStepDelay):
    """Softens the force of every user but the first."""

    def step(self, ports, body):
        for port in ports[1:]:
            port.f_s = 0.5 * port.f_s
        return super().step(ports, body)


ENDS = {
    end.__name__.lower(): end
    for end in (Hidden, Enclosed, Dead, Clipped, Fading, Undeclared, Branching)
}


def controller(name, end):
    return dataclasses.replace(
        LIBRARY["pmwvc"],
        name=name,
        linear=name,
        words=end.__doc__,
        make_master=lambda params, baseline: end(params),
        make_strict=None,
    )


@pytest.fixture(scope="module", autouse=True)
def lab():
    """The examples of the documentation, and ends whose models would be wrong."""
    examples = {}
    for page in ("controllers.md", "couplings.md"):
        exec(source_of(page)[1], examples)
    group, couplings = library.RECORDS.plugins.group, COUPLINGS.plugins.group
    ends = {name: controller(name, end) for name, end in ENDS.items()}
    ends["strict"] = dataclasses.replace(LIBRARY["pmwvc"], name="strict", linear="strict")
    late = COUPLINGS.library["one_step_delay"]
    own = {
        solver.__name__.lower(): dataclasses.replace(
            late, name=solver.__name__.lower(), linear=solver.__name__.lower(), make=solver
        )
        for solver in (Remembering, Failing, Ordered)
    }
    with pytest.MonkeyPatch.context() as patch:
        points = offer(patch, group, "lab_ends", ends | {"soft": examples["SOFT"]})
        known = own | {"averaged": examples["AVERAGED"]}
        offer(patch, couplings, "lab_couplings", known, kept=points)
        plugins.imported.cache_clear()
        yield
    plugins.imported.cache_clear()


@settings(max_examples=8, deadline=None)
@given(scenarios(), st.booleans())
def test_the_library_passes_what_code_from_outside_has_to(scenario, strict):
    """Two hyperperiods are the model applied twice, and it is the same at a real amplitude."""
    if strict and scenario.controller == "pmwvc":
        assume(scenario.users[0].master.position.feedback != "printed")
        scenario = trial(dataclasses.replace(scenario, channel="strict", controller="strict"))
    loop = Hyperperiod(scenario)
    once, _ = loop.around()
    twice, _ = Hyperperiod(scenario).around(rounds=2)
    large, _ = Hyperperiod(scenario).around(one=STRICT_AMPLITUDE if scenario.strict else AMPLITUDE)
    square = once @ once
    assert np.abs((square - twice)[..., loop.units]).max() < 1e-12 * np.abs(square).max()
    assert np.abs(large - once).max() < 1e-12 * np.abs(once).max()


def with_(scenario, *, controller="pmwvc", coupling=None):
    """Return a scenario with parts of the lab."""
    server = dataclasses.replace(scenario.server, coupling=coupling or scenario.server.coupling)
    return dataclasses.replace(scenario, controller=controller, server=server)


@settings(max_examples=8, deadline=None)
@given(scenarios())
def test_the_model_of_a_controller_does_what_the_simulator_does(scenario):
    assume(scenario.controller == "pmwvc")
    soft = with_(scenario, controller="soft")
    assume(bounded(build(soft)))
    assert compare(soft) < 1e-9


@settings(max_examples=8, deadline=None)
@given(scenarios())
def test_the_model_of_a_coupling_does_what_the_simulator_does(scenario):
    assume(scenario.controller == "pmwvc" and not scenario.coupling.black_box)
    averaged = with_(scenario, coupling="averaged")
    assume(bounded(build(averaged)))
    assert compare(averaged) < 1e-9


def test_the_models_are_their_own_and_not_those_of_the_library():
    own = linear_loops.scenario(link__delay_s=0.008, server__coupling="one_step_delay")
    for other in (with_(own, controller="soft"), with_(own, coupling="averaged")):
        assert compare(other, model=build(own)) > 1e-3


@pytest.mark.parametrize("period_s", [0.004, 0.012])
def test_there_is_a_model_on_the_strict_channel_at_unequal_rates(period_s):
    values = {"link__delay_s": 0.008, "channel": "strict", "server__period_s": period_s}
    radii = stability.radii(with_(linear_loops.scenario(**values), coupling="averaged"))
    assert 0.5 < radii[0] < 1.5


def growth(scenario, ticks=4000):
    """Return how much larger the forces of a pushed loop are at the end than halfway."""
    force = np.zeros((2, ticks))
    force[0, :50] = 1.0
    traces = linear_loops.simulated(scenario, force)
    pulls = np.abs(np.stack([user.f_m[-ticks:, 0] for user in traces.users]))
    half = ticks // 2
    return float(pulls[:, -400:].max() / pulls[:, half - 400 : half].max())


def test_the_largest_stable_stiffness_separates_what_decays_from_what_grows():
    base = with_(linear_loops.scenario(link__delay_s=0.016), coupling="averaged")
    limit = stability.k_max(base).first
    assert limit is not None
    for factor, grows in ((0.9, False), (1.1, True)):
        settings = {"server__contact_stiffness": factor * limit}
        near = linear_loops.scenario(link__delay_s=0.016, **settings)
        assert (growth(with_(near, coupling="averaged")) > 1.0) is grows


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("hidden", "controller = hidden: two hyperperiods .* state that it does not declare"),
        ("enclosed", "controller = enclosed: two hyperperiods .* state that it does not declare"),
        ("fading", "controller = fading: two hyperperiods .* or changes with time"),
        ("dead", "controller = dead: not linear: signals of 0.0078 and of 9e-13"),
        ("clipped", "controller = clipped: not linear|superposition does not hold"),
        ("undeclared", "Undeclared does not declare its state"),
        ("branching", "controller = branching: not stepped on arrays: ValueError"),
    ],
)
def test_an_end_whose_model_would_be_wrong_has_none(name, reason):
    scenario = with_(linear_loops.scenario(link__delay_s=0.008), controller=name)
    with pytest.raises(NonlinearError, match=reason):
        stability.radii(scenario)
    assert not any("Stable:" in line for line in prediction_text.lines(scenario, live=False))


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("remembering", "coupling = remembering: two hyperperiods in a row"),
        ("failing", "coupling = failing: .*raised ZeroDivisionError: no mass"),
    ],
)
def test_a_coupling_whose_model_would_be_wrong_has_none(name, reason):
    scenario = with_(linear_loops.scenario(link__delay_s=0.008), coupling=name)
    with pytest.raises(NonlinearError, match=reason):
        stability.radii(scenario)


def test_a_coupling_may_treat_equal_users_differently():
    """The library's may not: its equal users are one problem with a weight."""
    scenario = with_(linear_loops.scenario(link__delay_s=0.008), coupling="ordered")
    whole = build(scenario)
    assert compare(scenario, model=whole) < 1e-9
    assert stability.radii(scenario)[0] == pytest.approx(spectral_radius(whole), rel=1e-9)


def test_nothing_is_proved_of_code_from_another_package():
    proved = {"master__impedance": 22.87, "master__filter__cutoff_hz": 12.5}
    own = linear_loops.scenario(master__filter__pole_rad_s=None, **proved)
    assert any_delay(own).proved
    assert any_delay(with_(own, controller="soft")) is None
    averaged = any_delay(with_(own, coupling="averaged"))
    assert not averaged.proved
    assert "no bound is known for the server's coupling" in averaged.reasons
