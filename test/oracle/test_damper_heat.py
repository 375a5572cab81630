# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The heat that a server counts, with contacts that are dampers only: F^2/B for every coupling."""

import numpy as np
import pytest
from support.simulated import simulated

from pmwvc_bringup import scenarios
from pmwvc_core.server.couplings import COUPLINGS

DAMPING = 10.0
KNOWN = [name for name, each in COUPLINGS.library.items() if not each.black_box]
SETTINGS = (
    *("server.contact=bilateral", "server.contact_stiffness=0", "task.grip_s=0.2"),
    f"server.contact_damping={DAMPING}",
)


@pytest.mark.parametrize(
    "name", [n for n, each in COUPLINGS.library.items() if not each.black_box]
)
def test_the_heat_of_a_step_is_that_of_the_dampers(name):
    texts = [*SETTINGS, f"server.coupling={name}"]
    scenario = scenarios.load("carry_16ms", settings_texts=texts, duration_s=1.5)
    server = simulated(scenario).server
    heat = sum((force[:, 0] ** 2 for force in server.f_s), 0.0) * server.period_s / DAMPING
    found = np.diff(server.dissipated, prepend=0.0)
    np.testing.assert_allclose(found, heat, rtol=1e-9, atol=1e-15 * (1.0 + heat.sum()))
    assert heat.sum() > 1e-6
