# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Couplings by name: the library, and one of another package through the whole program."""

import dataclasses
import json
from typing import Any, NamedTuple

import numpy as np
import pytest
from support.lab import example_of, offer
from support.plain import load

from pmwvc_analysis.events.events import complete
from pmwvc_analysis.models.any_delay import any_delay
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_core import plugins
from pmwvc_core.errors import ParameterError, ScenarioError
from pmwvc_core.law.server.contacts import couple
from pmwvc_core.law.server.coupling import Implicit, OneStepDelay
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.server.couplings import COMPENSATIONS, COUPLINGS
from pmwvc_core.simulation.session import simulate_one

AVERAGED = ("--set", "server.coupling=averaged")
PROVED = (  # stable at any delay with implicit
    "master.impedance=22.87",
    "master.hold=zoh",
    "master.filter.kind=first_order",
    "master.filter.cutoff_hz=12.5",
)


@pytest.fixture(scope="module")
def pmwvc(tmp_path_factory):
    """The command line beside an installed package: the example of the documentation."""
    with example_of(tmp_path_factory.mktemp("lab"), "couplings.md") as run:
        yield run


def test_a_coupling_of_another_package_is_simulated_judged_and_reported(pmwvc, tmp_path):
    out = tmp_path / "one"
    result = pmwvc(
        "simulate", "carry_16ms", *AVERAGED, "--duration", "2", "--no-figures", "--out", out
    )
    assert result.returncode == 0, result.stderr
    assert "mean of the last two forces" in result.stdout
    assert "  Stable: spectral radius" in result.stdout
    assert "averaged comes from another package: its model is that of" in result.stdout
    assert "round trip" not in result.stdout  # its lag is not known
    assert "contradict" not in result.stdout
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    assert summary["stable"] is True
    assert summary["prediction"]["stable"] is True
    assert summary["prediction"]["k_felt"] is None


def test_a_coupling_of_another_package_is_tuned_by_its_own_model(pmwvc):
    result = pmwvc("tune", "wall", *AVERAGED, "--set", "channel=plain", "--set", "duration_s=2")
    assert result.returncode == 0, result.stderr
    assert "computed with" not in result.stdout
    assert "proposed: simulated for 2 s with the scenario's hands: stable" in result.stdout


SOON = ("safety.soft_start_s=0.05", "task.grip_s=0.05", "task.grip_rise_s=0.3")
FAILED = slice(80, 90)  # steps, in the grip


STEPS = []


class Torn(NamedTuple):
    """A law of the library that fails in ten steps."""

    law: Any


@couple.member(Torn)
def torn(p, avatars, body, law):
    """Step, then fail."""
    STEPS.append(1)
    found = couple(p.law, avatars, body, law)
    if FAILED.start < len(STEPS) <= FAILED.stop:
        raise ZeroDivisionError("no mass")
    return found


def unmade(old_s, new_s):
    """Fail."""
    raise KeyError("table")


@pytest.fixture
def lab(monkeypatch):
    """A laboratory's own module with records, good and bad."""
    own = COUPLINGS.library["implicit"]
    records = {
        "exact": dataclasses.replace(own, name="exact"),
        "doubtful": dataclasses.replace(own, name="doubtful", passive=lambda params: False),
        "alone": dataclasses.replace(own, name="alone", linear=None),
        "torn": dataclasses.replace(own, name="torn", law=lambda old_s, new_s: Torn(Implicit(0))),
        "torn_late": dataclasses.replace(
            COUPLINGS.library["one_step_delay"],
            name="torn_late",
            law=lambda old_s, new_s: Torn(OneStepDelay(old_s, new_s)),
        ),
        "unmade": dataclasses.replace(own, name="unmade", law=unmade),
        "stone": object(),
    }
    offer(monkeypatch, COUPLINGS.plugins.group, "lab_couplings", records)
    plugins.imported.cache_clear()
    yield
    plugins.imported.cache_clear()


def scenario(coupling):
    values = {"name": "one", "controller": "pmwvc", "channel": "plain", "users": 1}
    return parse_scenario(values | {"duration_s": 0.2, "server": {"coupling": coupling}})


@pytest.mark.parametrize(("name", "own"), [("torn", "implicit"), ("torn_late", "one_step_delay")])
def test_a_step_that_fails_is_solved_exactly_counted_and_named(lab, name, own):
    """The control is the same coupling whole: until the first fault they are the same bits."""
    STEPS.clear()
    known, whole = (
        load("carry_16ms", settings_texts=[*SOON, f"server.coupling={each}", "duration_s=1.5"])
        for each in (name, own)
    )
    traces, control = simulate_one(known), simulate_one(whole)
    server = traces.server
    for user in range(2):
        assert np.abs(server.f_s[user][FAILED]).min() > 0.1
        power = np.ravel(server.f_s[user] * server.xd_s[user])[FAILED]
        waves = np.ravel(server.u_s[user] ** 2 - server.v_s[user] ** 2)[FAILED]
        assert power == pytest.approx(0.5 * waves, abs=1e-12)
        same = slice(0, FAILED.start if own != "implicit" else None)
        assert (server.f_s[user][same] == control.server.f_s[user][same]).all()
    fault = f"server.coupling = '{name}' raised ZeroDivisionError: no mass"
    assert traces.metadata["coupling"] == {"contained_steps": "10", "last_fault": fault}
    text = f"the coupling failed in 10 steps: {fault}"
    assert any(each["what"] == text for each in complete(traces, known))
    assert inconsistencies(traces, known) == []
    assert "coupling" not in control.metadata


def test_what_is_proved_rests_on_what_the_record_gives(lab):
    doubtful, exact, own = (
        any_delay(load("carry_16ms", settings_texts=[*PROVED, f"server.coupling={name}"]))
        for name in ("doubtful", "exact", "implicit")
    )
    assert own.proved
    assert exact.proved
    assert not doubtful.proved
    assert "no bound is known for the server's coupling" in doubtful.reasons


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("unmade", "'unmade' cannot be made: KeyError: 'table'"),
        ("stone", "= 'stone'.*is not a coupling: it is a object, must be a record"),
        ("moon", "= 'moon'.*must be one of implicit, one_step_delay, .*unknown, .*exact"),
    ],
)
def test_what_is_no_coupling_or_cannot_be_made_is_refused_with_the_reason(lab, name, text):
    with pytest.raises((ScenarioError, ParameterError), match=text):
        simulate_one(scenario(name))


def test_a_compensation_may_come_from_another_package(monkeypatch):
    half = dataclasses.replace(COMPENSATIONS.library["ledger"], name="half", linear=None)
    offer(monkeypatch, COMPENSATIONS.plugins.group, "lab_compensations", {"half": half})
    texts = ["server.coupling=unknown", "server.environment=wall", "server.compensation=half"]
    traces = simulate_one(load("carry_0ms", settings_texts=[*texts, "duration_s=0.5"]))
    assert "tank" in traces.server.accounts
