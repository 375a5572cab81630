# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability of the exact model against printed and checked numbers, and against a second route."""

import dataclasses
from typing import Any, NamedTuple

import numpy as np
import pytest
from support import linear_loops
from support.lab import offer

from pmwvc_analysis.models.stability import k_max, radii
from pmwvc_analysis.models.variation import with_stiffness
from pmwvc_core import plugins
from pmwvc_core.law.server.contacts import couple
from pmwvc_core.law.wave.wave import wave_velocity
from pmwvc_core.scenario.names import varied
from pmwvc_core.server.couplings import COUPLINGS
from reproduction.single_user import z_width

FRAME_S, POLE_50_HZ = 0.008, 100.0 * np.pi
BOUND = 1e4  # N/m: above all that is printed
# Largest symmetric stiffness [N/m] of two users, App. B, for 0 to 3 frames of delay each way; of
# direct coupling: ``test_reproduction.py``.
LARGEST = [
    ({"server__coupling": "one_frame_late"}, 50.0, (5280.5, 2470.8, 2166.0, 2224.2)),
    ({"server__coupling": "one_frame_late"}, 100.0, (1037.4, 988.2, 965.4, 952.2)),
    (
        {"server__coupling": "one_frame_late", "master__hold": "foh"},
        50.0,
        (4528.2, 2433.9, 2164.5, 2181.7),
    ),
    (
        {"server__coupling": "one_frame_late", "master__hold": "foh"},
        100.0,
        (973.2, 943.0, 928.3, 919.8),
    ),
    (
        {"server__coupling": "one_step_delay", "server__integrator": "forward_euler"},
        50.0,
        (2950.1, 3084.7, 2604.5, 2674.5),
    ),
    (
        {"server__coupling": "one_step_delay", "server__integrator": "backward_euler"},
        50.0,
        (8482.3, 3595.2, 2774.5, 2488.5),
    ),
    # 50 Hz read as -20 dB moves the limits, as -3 dB leaves nothing stable.
    ({"server__coupling": "one_frame_late"}, POLE_50_HZ / np.sqrt(99.0), (4850, 2854, 2810, 3093)),
    ({"server__coupling": "one_frame_late"}, POLE_50_HZ, (0.0,)),
]


@pytest.mark.parametrize(("values", "pole", "largest"), LARGEST)
def test_the_largest_stiffness_of_app_b(values, pole, largest):
    for frames, expected in enumerate(largest):
        scenario = linear_loops.scenario(
            master__filter__pole_rad_s=pole, link__delay_s=frames * FRAME_S, **values
        )
        assert k_max(scenario, bound=BOUND).first == pytest.approx(expected, rel=5e-3, abs=1e-9)


class AsPrinted(NamedTuple):
    """App. B, Eq. 14 with the sign that it has in print."""

    late: Any


@couple.member(AsPrinted)
def as_printed(p, avatars, body, law):
    """Step one frame late, with the force of the other sign."""
    avatars, *others = couple(p.late, avatars, body, law)
    wrong = (wave_velocity(a.impedance, a.u, tuple(-f for f in a.f)) for a in avatars)
    return tuple(a._replace(xd=xd) for a, xd in zip(avatars, wrong, strict=True)), *others


def test_equation_14_as_published_is_far_from_its_own_figure(monkeypatch):
    """The control: 5,280 N/m and less above."""
    own = COUPLINGS.library["one_frame_late"]
    law = {"law": lambda *of: AsPrinted(own.law(*of)), "linear": "printed"}
    record = dataclasses.replace(own, name="printed", **law)
    offer(monkeypatch, COUPLINGS.plugins.group, "lab_couplings", {"printed": record})
    plugins.imported.cache_clear()
    for frames, expected in ((0, 139), (3, 70)):
        of = linear_loops.scenario(server__coupling="printed", link__delay_s=frames * FRAME_S)
        assert k_max(of, bound=BOUND).first == pytest.approx(expected, rel=1e-2)
    plugins.imported.cache_clear()


@pytest.mark.parametrize(("hold", "delay_s"), [("zoh", 0.0), ("foh", 0.024), ("zoh", 0.4)])
def test_the_implicit_coupling_has_no_largest_stiffness(hold, delay_s):
    scenario = linear_loops.scenario(master__hold=hold, link__delay_s=delay_s)
    assert k_max(scenario, bound=1e7).first is None


STACKED = [
    ("master.velocity_filter.share", (0.1, 0.5, 0.9), {"master__velocity_filter__kind": "exact"}),
    (
        "master.velocity_filter.cutoff_hz",
        (20.0, 60.0),
        {"master__velocity_filter__kind": "complementary"},
    ),
    ("master.bank.split_rad_s", (20.0, 90.0), {"master__bank__kind": "complementary"}),
    ("master.local_model.stiffness", (0.0, 100.0, 2e3), {"master__bank__kind": "dissertation"}),
    ("master.position.gain", (0.0, 5.0, 30.0), {"master__position__feedback": "printed"}),
    ("baseline.virtual_coupling.stiffness", (50.0, 900.0), {"controller": "virtual_coupling"}),
    (
        "server.contact_damping",
        (0.0, 9.0),
        {
            "server__coupling": "unknown",
            "server__compensation": "none",
            "server__decoding": "late",
        },
    ),
]


@pytest.mark.parametrize(("name", "values", "others"), STACKED)
def test_parameters_around_the_port_stack(name, values, others):
    scenario = linear_loops.scenario(link__delay_s=0.016, **others)
    together = radii(*(varied(scenario, name, value) for value in values))
    alone = [radii(varied(scenario, name, value))[0] for value in values]
    np.testing.assert_allclose(together, alone, rtol=1e-9)
    assert np.ptp(alone) > 1e-9


ISLANDS = [
    ({"server__coupling": "one_step_delay", "server__contact_damping": 0.0}, 0.024),
    ({"server__coupling": "one_frame_late", "server__contact_damping": 20.0}, 0.008),
]


@pytest.mark.parametrize(("values", "delay_s"), ISLANDS)
def test_islands_above_the_first_crossing_are_found(values, delay_s):
    scenario = linear_loops.scenario(link__delay_s=delay_s, **values)
    limit = k_max(scenario)
    assert len(limit.islands) == 1
    edges = [limit.first, *limit.islands[0]]
    for edge, (below, above) in zip(
        edges, [(True, False), (False, True), (True, False)], strict=True
    ):
        for factor, stable in ((0.999, below), (1.001, above)):
            if edge > 0.0:
                radius = radii(with_stiffness(scenario, edge * factor))[0]
                assert bool(radius <= 1.0) is stable


def test_the_z_width_narrows_with_damping_where_the_computation_is_late():
    late = {"server__coupling": "one_step_delay", "server__environment": "wall", "users": 1}
    damping = [0.0, 10.0, 30.0]
    limits = z_width(linear_loops.scenario(**late), damping)
    firsts = [limit.first for limit in limits]
    assert firsts == sorted(firsts, reverse=True)
    for b, limit in zip(damping, limits, strict=True):
        for factor, stable in ((0.999, True), (1.001, False)):
            scenario = linear_loops.scenario(
                server__contact_damping=b, server__contact_stiffness=limit.first * factor, **late
            )
            assert bool(radii(scenario)[0] <= 1.0) is stable
    at_once = linear_loops.scenario(**late | {"server__coupling": "implicit"})
    assert [limit.first for limit in z_width(at_once, damping)] == [None] * 3
