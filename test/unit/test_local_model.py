# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The local model: the wave port of a spring and damper."""

import numpy as np
import pytest
from support.law_rigs import Port
from support.port_parts import TICK_S, master

from pmwvc_core.law.port.filter_bank import (
    LocalModel,
    local_answer,
    local_offer,
    local_stored_j,
)


class LocalPort:
    """The local model of a master with its wave port, along one axis."""

    def __init__(self, params):
        p = Port(params).p.port.filters
        self.p, self.b = p.far.local, p.impedance
        self.s = LocalModel((0.0,), (0.0,), 0.0, True, 0.0)

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
