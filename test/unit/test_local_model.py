# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Local models: the wave port of a spring and damper, and models from elsewhere."""

import dataclasses
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.bank_runs import TICK_S, driven, master
from support.law_rigs import Port
from support.strategies import signals

from pmwvc_core.controllers import plugged_local
from pmwvc_core.errors import ParameterError
from pmwvc_core.law.port.filter_bank import (
    local_answer,
    local_offer,
    local_stored_j,
    resting_local,
)
from pmwvc_core.params import LocalModelParams


class LocalPort:
    """The local model of a master with its wave port, along one axis."""

    def __init__(self, params):
        p = Port(params).p.port.filters
        self.p, self.b = p.far.local, p.impedance
        self.s = resting_local(self.p, 1)

    def offer(self, x=0.0):
        self.s, v0, (gain,) = local_offer(self.s, (x,), self.p, self.b)
        return v0[0], gain

    def step(self, u):
        self.s, v = local_answer(self.s, (u,), self.p, self.b)
        return v[0]

    @property
    def stored_j(self):
        return local_stored_j(self.s, self.p)


def test_the_wave_of_a_spring_and_damper_is_that_of_the_midpoint_rule():
    """b = 25, K = 500, B = 5, at rest: G = 5.25, v = (b - G)/(b + G) u."""
    port = LocalPort(master(stiffness=500.0, damping=5.0))
    v0, gain = port.offer()
    assert v0 == 0.0
    assert gain == pytest.approx(19.75 / 30.25)
    v2 = port.step(2.0)
    assert v2 == pytest.approx(2.0 * gain)
    xd = (2.0 + v2) / np.sqrt(50.0)
    assert port.s.x[0] == pytest.approx(TICK_S * xd)
    v0, _ = port.offer()
    assert v0 == pytest.approx(-np.sqrt(2.0 / 25.0) * 500.0 * TICK_S * xd / (1.0 + 5.25 / 25.0))


def test_a_one_sided_model_lets_go_of_its_spring_beyond_its_face():
    port = LocalPort(master(stiffness=500.0, damping=0.0, acts="above", begins_m=0.0))
    for _ in range(5):
        port.offer(0.01)
        port.step(1.0)
    stored_j = port.stored_j
    assert stored_j > 0.0
    assert port.offer(-0.01) == (0.0, 1.0)
    assert port.step(1.0) == 1.0
    assert (port.stored_j, port.s.dissipated_j) == (0.0, stored_j)


class Plugged:
    """A plug-in's spring; what it answers can be spoilt."""

    def __init__(self, params):
        self.params = params
        self.spoilt = None

    def step(self, position, velocity, dt):
        if self.spoilt is ZeroDivisionError:
            raise ZeroDivisionError("no such place")
        if self.spoilt is not None:
            return self.spoilt
        return self.params.stiffness * position + self.params.damping * velocity


class Sloped(Plugged):
    """The same, and it tells its slope."""

    def local(self, position, dt):
        k, damping = self.params.stiffness, self.params.damping
        return k * position, np.full_like(position, k * dt + damping)


@pytest.fixture
def plugged(monkeypatch):
    """Entry points as an installed package would have them."""
    points = [
        EntryPoint(name, f"{__name__}:{kind}", plugged_local.PLUGINS.group)
        for name, kind in (("plain", "Plugged"), ("sloped", "Sloped"))
    ]
    monkeypatch.setattr("pmwvc_core.plugins.entry_points", lambda group: points)


def test_the_model_in_the_docs_is_the_built_in_one(monkeypatch):
    text = (Path(__file__).resolve().parents[2] / "docs" / "local_models.md").read_text("utf-8")
    found: dict[str, type] = {}
    exec(text.split("```python\n")[1].split("```")[0], found)
    monkeypatch.setattr(f"{__name__}.Sloped", found["Rubber"])
    points = [EntryPoint("rubber", f"{__name__}:Sloped", plugged_local.PLUGINS.group)]
    monkeypatch.setattr("pmwvc_core.plugins.entry_points", lambda group: points)
    rubber = dataclasses.replace(master(), local_model=LocalModelParams(kind="rubber"))
    motions = np.random.default_rng(8).normal(size=80).tolist()
    np.testing.assert_allclose(
        driven(Port(rubber), motions), driven(Port(master()), motions), rtol=1e-9
    )


@pytest.mark.usefixtures("plugged")
@given(waves=signals(longest=150), stiffness=st.floats(0.0, 1e6), damping=st.floats(0.0, 200.0))
@settings(deadline=None)
def test_deficit_of_an_unknown_model_is_at_most_one_tick(waves, stiffness, damping):
    params = dataclasses.replace(
        master(), local_model=LocalModelParams(kind="plain", stiffness=stiffness, damping=damping)
    )
    port = LocalPort(params)
    balance, paying = 0.0, 0.0
    for u in waves.tolist():
        port.offer()
        v = port.step(u)
        gained = 0.5 * TICK_S * (u * u - v * v)
        assert balance >= -1e-12 or gained >= -1e-12, "gave more while in deficit"
        balance, paying = balance + gained, max(paying, -gained)
        assert balance >= -paying - 1e-9
    assert port.stored_j == pytest.approx(balance, rel=1e-6, abs=1e-9)


@pytest.mark.usefixtures("plugged")
@pytest.mark.parametrize("spoilt", [ZeroDivisionError, np.array([[np.nan]]), np.zeros(3), "no"])
def test_a_model_that_fails_is_a_matched_damper_from_then_on(spoilt, caplog):
    params = dataclasses.replace(master(), local_model=LocalModelParams(kind="plain"))
    port = LocalPort(params)
    port.offer()
    port.step(1.0)
    port.s.model.spoilt = spoilt
    for _ in range(3):
        port.offer()
        v = port.step(1.0)
    assert v == 0.0
    assert "master.local_model.kind = 'plain'" in caplog.text
    assert caplog.text.count("matched damper") == 1


def test_a_model_that_is_not_there_is_refused_by_name():
    params = dataclasses.replace(master(), local_model=LocalModelParams(kind="jelly"))
    with pytest.raises(ParameterError, match=r"kind = 'jelly': not installed.*spring_damper"):
        Port(params)
