# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Z-width by two routes: eigenvalues of the exact model, and sessions that are simulated."""

import pytest

from pmwvc_core.simulation.session import simulate_one
from reproduction.scenarios import scenario, wall
from reproduction.simulated_width import decays, simulated_z_width
from reproduction.single_user import z_width

DAMPING = [0.0, 7.0]
STEP = 7.8125  # N/m

LATE = {"server__coupling": "one_step_delay", "server__integrator": "backward_euler"}
CASES = {
    "direct": ("direct", {}),
    "waves": ("pmwvc", LATE),
    "waves, trapezoid": ("pmwvc", LATE | {"server__integrator": "trapezoid"}),
}


def wall_of(case):
    controller, values = CASES[case]
    return scenario(wall(**values), users=1, controller=controller)


@pytest.mark.parametrize("case", CASES)
def test_sessions_lose_stability_where_the_exact_model_does(case):
    of = wall_of(case)
    limits = [limit.first for limit in z_width(of, DAMPING)]
    for b, limit in zip(DAMPING, limits, strict=True):
        below, above = limit - STEP, limit + STEP
        assert below > 0.0
        assert simulated_z_width(of, b, highest=below, parts=1, rounds=1) == (below, None)
        assert simulated_z_width(of, b, highest=above, parts=1, rounds=1) == (0.0, above)


def test_both_routes_agree_within_the_step_of_the_bisection():
    of = wall_of("waves")
    (limit,) = z_width(of, [7.0])
    bracket = simulated_z_width(of, 7.0, highest=2000.0, parts=2, rounds=5)
    assert bracket.high - bracket.low <= 8.0 * STEP * (1.0 + 1e-9)
    assert bracket.low - STEP <= limit.first <= bracket.high + STEP


def test_where_all_is_stable_no_upper_end_is_claimed():
    of = scenario(wall(server__coupling="implicit"), users=1)
    bracket = simulated_z_width(of, 10.0, highest=3000.0, parts=2, rounds=2)
    assert bracket == (3000.0, None)


def test_help_from_the_safety_limits_does_not_count_as_stable():
    values = wall(server__contact_stiffness=3000.0, server__contact_damping=5.0)
    push = {"kind": "constant", "force": 1.0}
    of = scenario(values, users=1, controller="direct", operator=push, duration_s=4.0)
    traces = simulate_one(of)
    assert int(traces.users[0].safety_events) > 0
    assert not decays(traces)
