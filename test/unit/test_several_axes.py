# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Sessions with one to six axes, for every controller: no axis is special, no batch differs."""

import numpy as np
import pytest
from support import plain as scenarios
from support.simulated import judged, simulated
from support.strategies import text_of

from pmwvc_analysis.models.stability import radii
from pmwvc_analysis.prediction.prediction import prediction
from pmwvc_analysis.traces.consistency import inconsistencies
from pmwvc_analysis.verdicts.verdicts import summary
from pmwvc_core.controllers.library import LIBRARY
from pmwvc_core.errors import ParameterError
from pmwvc_core.params.server import COUPLINGS
from pmwvc_core.plant.forces import RecordedForce, recorded_params
from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.simulation.conditions import Conditions
from pmwvc_core.simulation.session import simulate_one

TICKS, TICK_S = 320, 0.001
AXIS_BY_AXIS = ("pmwvc", "direct", "virtual_coupling")  # the others have one energy for all axes
FEEDBACKS = ("printed", "budgeted", "integral")
VARIANTS = [
    *({"controller": name} for name in LIBRARY),
    *({"server.coupling": name} for name in COUPLINGS if name != "implicit"),
    *({"master.velocity_filter.kind": k} for k in ("exact", "equivalent", "complementary")),
    *({"master.bank.kind": k} for k in ("dissertation", "complementary")),
    *({"master.position.feedback": k, "master.position.gain": 5.0} for k in FEEDBACKS),
]
IDS = [next(iter(v.values())) + "_" + next(iter(v)).split(".")[-1] for v in VARIANTS]


def scenario_of(dof, *, matrix=None, **overrides):
    values = {
        "master.impedance_matrix": "" if matrix is None else text_of(matrix),
        "safety.soft_start_s": 0.05,
        "server.contact_stiffness": 200.0,
        "link.delay_s": 0.008,
    }
    base = {
        "name": "axes",
        "duration_s": TICKS * TICK_S,
        "controller": "pmwvc",
        "channel": "plain",
        "users": 2,
    }
    return parse_scenario(base, overrides=values | {"dof": dof} | overrides)


def pushed(scenario, forces):
    """Simulate users whose hands push with forces ``(users, ticks, dof)``."""

    hands = {
        user.name: (RecordedForce(0), recorded_params(rows, scenario.dof, False, early=True))
        for user, rows in zip(scenario.users, forces, strict=True)
    }
    return simulate_one(scenario, Conditions(hands=hands))


def free(dof, **settings):
    return scenario_of(
        dof,
        **{"server.contact": "bilateral", "task.kind": "free", "operator.kind": "none"},
        **settings,
    )


def wobbling(seed, dof):
    """Return smooth forces of two users in all directions, after the soft start [N]."""
    rng = np.random.default_rng(seed)
    time_s = np.maximum(np.arange(TICKS) * TICK_S - 0.1, 0.0)
    swing = np.sin(2 * np.pi * np.multiply.outer(time_s, rng.uniform(0.5, 4.0, (2, dof))))
    return np.moveaxis(swing * rng.uniform(-0.4, 0.4, (2, dof)), 1, 0)


def signals(traces):
    """Return per quantity what does not depend on where the session began."""
    users, server = traces.users, traces.server
    for user in users:
        yield from (user.x_m - user.x_m[0], user.xd_m, user.f_applied, user.u_m, user.v_m)
    yield from (server.x_o, *server.f_s, *server.xd_s)


def tilted(dof, seed=3):
    rng = np.random.default_rng(seed)
    axes, _ = np.linalg.qr(rng.normal(size=(dof, dof)))
    return (axes * rng.uniform(12.0, 40.0, dof)) @ axes.T


@pytest.mark.parametrize("variant", VARIANTS, ids=IDS)
def test_turning_forces_and_impedance_together_turns_the_session(variant):
    dof = 6
    turn, _ = np.linalg.qr(np.random.default_rng(dof).normal(size=(dof, dof)))
    matrix, forces = tilted(dof), wobbling(1, dof)
    straight = pushed(free(dof, matrix=matrix, **variant), forces)
    turned = pushed(free(dof, matrix=turn @ matrix @ turn.T, **variant), forces @ turn.T)
    assert max(np.abs(user.f_applied).max() for user in straight.users) > 0.05
    for one, two in zip(signals(straight), signals(turned), strict=True):
        np.testing.assert_allclose(one @ turn.T, two, atol=1e-8 * (1.0 + np.abs(one).max()))


@pytest.mark.parametrize("controller", AXIS_BY_AXIS)
def test_every_axis_does_what_it_does_alone_unless_the_impedance_is_tilted(controller):
    forces = wobbling(2, 3)
    together = list(signals(pushed(free(3, controller=controller), forces)))
    for axis in range(3):
        alone = signals(pushed(free(1, controller=controller), forces[:, :, axis : axis + 1]))
        for one, two in zip(together, alone, strict=True):
            np.testing.assert_allclose(one[:, axis], two[:, 0], rtol=1e-9, atol=1e-9)
    if controller == "pmwvc":  # the control
        coupled = signals(pushed(free(3, matrix=tilted(3)), forces))
        assert (
            max(np.abs(one - two).max() for one, two in zip(together, coupled, strict=True)) > 1e-5
        )


def test_recordings_fit_themselves_and_their_impedance():
    scenario = free(3, matrix=tilted(3), **{"server.impedance": 30.0})
    traces = pushed(scenario, wobbling(4, 3))
    assert inconsistencies(traces, scenario) == []
    other = inconsistencies(traces, free(3, **{"server.impedance": 30.0}))
    assert any("F is not b xd - sqrt(2b) v_m" in line for line in other)
    result = summary(traces, scenario)
    assert len(result["users"][0]["force_final_n"]) == 3
    assert all(user["passive"] for user in result["users"])


def test_what_is_foretold_of_a_diagonal_matrix_is_what_a_force_along_the_first_axis_meets():
    """But the axis of 10 N s/m is the first to lose stability."""
    loose = {"server.coupling": "one_step_delay", "server.contact_damping": 1.0}
    matrix, scalar = {"matrix": [[30.0, 0.0], [0.0, 10.0]]}, {"master.impedance": 30.0}
    both, number = foretold(**matrix, **loose), foretold(**scalar, **loose)
    for name in ("k_felt", "mass_felt"):
        assert both[name] == pytest.approx(number[name])
    stiff = loose | {"server.contact_stiffness": 1000.0}
    assert radii(free(2, **scalar, **stiff)) < 1.0 < radii(free(2, **matrix, **stiff))
    assert not both["any_delay"], "late decoding at a cube has no bound"


@pytest.mark.parametrize(("first", "stable"), [(30.0, True), (600.0, False)])
def test_one_axis_on_which_b_t_over_m_is_above_2_is_enough(first, stable):
    solved = {"server.coupling": "implicit", "device.damping": 0.3}
    found = foretold(matrix=[[first, 0.0], [0.0, 10.0]], **solved)
    assert found["stable"] is stable


def foretold(**values):
    return prediction(free(2, **values), live=False)


def test_one_axis_has_no_sideways():
    with pytest.raises(ParameterError, match=r"task.sideways_m = 0.1: there is one axis only"):
        scenario_of(1, **{"task.sideways_m": 0.1})
    assert scenario_of(2, **{"task.sideways_m": 0.1}).task.sideways_m == 0.1


def test_cube_3d_is_carried_along_and_sideways_and_the_devices_give_way_across():
    """By B^-1 F times the lag, at rest in the grip and not yet carried."""
    scenario = scenarios.load("cube_3d", duration_s=9.0)
    traces, result = simulated(scenario), judged(scenario)
    user, server = traces.users[0], traces.server
    assert result["stable"] and result["object"]["path_error_rms_m"] < 0.002
    assert all(each["passive"] and each["safety_events"] == 0 for each in result["users"])
    np.testing.assert_allclose(server.x_o.max(axis=0), [0.05, 0.03, 0.0], atol=0.002)
    last = np.flatnonzero(server.time_s < 4.5)[-1]
    tick = np.searchsorted(user.time_s, server.time_s[last])
    apart = user.x_m[tick] - server.x_s[0][last]
    course = np.linalg.inv(scenario.users[0].impedance.matrix) @ user.f_applied[tick]
    np.testing.assert_allclose(apart, apart[0] / course[0] * course, rtol=0.1, atol=5e-6)
    assert apart[1] < -2e-4 < 2e-5 < apart[2]
