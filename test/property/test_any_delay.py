# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Stability at any constant delay is said only where the exact model finds it at every delay."""

import dataclasses

import numpy as np
import pytest
from support.linear_loops import scenario
from support.strategies import text_of

from pmwvc_analysis.models.any_delay import any_delay
from pmwvc_analysis.models.linearize import ROUNDING
from pmwvc_analysis.models.stability import radii
from pmwvc_analysis.prediction.environment import rule
from pmwvc_analysis.prediction.prediction import aliasing_gain
from pmwvc_analysis.transparency.transparency import untouched
from pmwvc_core.scenario.names import varied

# Drawn ones with every coupling, filter and number of users: those in which a wrong rule shows.
STRUCTURES = (3, 10, 13, 17, 20, 24, 26, 27, 32, 35, 36, 40)
RUNS = 8  # numbers for each: 96 scenarios
FRAMES = ((0, 0), (2, 3), (14, 14))  # of delay up and down
FILTERS = (
    {"kind": "integrate_and_dump"},
    {"kind": "first_order"},
    {"kind": "first_order", "stop_hz": 60.0},
    {"kind": "butterworth", "pass_hz": 20.0, "stop_hz": 60.0},
    {"kind": "none"},
)
COUPLINGS = (
    {"server.coupling": "implicit"},
    {"server.coupling": "one_step_delay"},
    {"server.coupling": "one_frame_late"},
    {"server.coupling": "unwrapped", "server.integrator": "trapezoid"},
    {
        "server.coupling": "unknown",
        "server.decoding": "late",
        "server.compensation": "none",
        "server.environment": "wall",
    },
)
RANGES = {
    "master.impedance": (8.0, 80.0),
    "server.impedance": (8.0, 80.0),
    "device.mass": (0.05, 0.6),
    "device.damping": (1e-3, 10.0),
    "server.contact_stiffness": (20.0, 8000.0),
    "server.contact_damping": (0.01, 40.0),
}


def structure(number):
    """A scenario without its numbers."""
    draw = np.random.default_rng([9, number])
    m = int(draw.choice([1, 2, 4, 8, 20]))
    coupling = COUPLINGS[draw.integers(len(COUPLINGS))]
    values = {
        "master.rate_drop": m,
        "server.period_s": m * 1e-3,
        "master.hold": str(draw.choice(["zoh", "foh"])),
        "users": int(draw.choice([1, 2])),
        "server.environment": str(draw.choice(["wall", "cube"])),
        **{f"master.filter.{k}": v for k, v in FILTERS[draw.integers(len(FILTERS))].items()},
        **coupling,
    }
    if "first_order" not in values["master.filter.kind"] or "master.filter.stop_hz" in values:
        values["master.filter.pole_rad_s"] = None
    return scenario(**{name.replace(".", "__"): value for name, value in values.items()}), draw


def numbered(of, numbers):
    for name, value in numbers.items():
        of = varied(of, name, value)
    return of


def drawn(number):
    """Return one scenario a run."""
    of, draw = structure(number)
    columns = {
        name: np.exp(draw.uniform(*np.log(span), size=(RUNS, 1))) for name, span in RANGES.items()
    }
    columns["device.damping"] *= draw.random((RUNS, 1)) < 0.7
    columns["server.contact_damping"] *= draw.random((RUNS, 1)) < 0.7
    return [
        numbered(of, {name: float(column[run, 0]) for name, column in columns.items()})
        for run in range(RUNS)
    ]


def worst_radius(runs, period_s, *, live):
    """Return the largest spectral radius of every run over several delays."""
    found = []
    for up, down in FRAMES:
        delays = {"link.up.delay_s": up * period_s, "link.down.delay_s": down * period_s}
        found.append(radii(*(numbered(run, delays) for run in runs), live=live))
    return np.max(found, axis=0)


def within_rule(user, of):
    found = rule(user, of)
    return found is not None and found.met


def part_by_part(of):
    """The rule that is not enough: small aliasing, b T/m < 2, K T + 2B <= b or implicit."""
    return all(
        aliasing_gain(user) <= 1.1
        and float(user.impedance) * user.master.tick_s / user.device.mass < 2.0
        and (of.server.coupling == "implicit" or within_rule(user, of))
        for user in of.users
    )


@pytest.fixture(scope="module")
def judged():
    """Per scenario: proof, proof without contact, exact radii, and the rule part by part."""
    rows = []
    for number in STRUCTURES:
        single = drawn(number)
        period, live = single[0].server.period_s, number % 3 == 0
        touching = worst_radius(single, period, live=live)
        free = worst_radius([untouched(one) for one in single], period, live=live)
        for run, one in enumerate(single):
            rows.append((any_delay(one, live=live), touching[run], free[run], part_by_part(one)))
    return rows


def test_nothing_proved_is_unstable_at_any_delay(judged):
    assert len(judged) == 96
    proved = [row for row in judged if row[0].proved]
    assert len(proved) > 40
    assert max(touching for _, touching, _, _ in proved) <= 1.0 + ROUNDING
    free = [free for proof, _, free, _ in proved if not proof.touching]
    assert len(free) > 13
    assert max(free) <= 1.0 + ROUNDING


def test_parts_that_are_passive_one_by_one_are_not_enough(judged):
    """The control: a held device gives out energy below b T/m = 2, and so does little aliasing."""
    wrong = [max(row[1], row[2]) > 1.0 + 1e-6 for row in judged if row[3]]
    assert sum(wrong) > 13


def test_most_of_what_is_stable_at_all_delays_tried_is_proved(judged):
    stable = [row for row in judged if row[1] < 1.0 - 1e-6]
    assert sum(row[0].proved for row in stable) > 0.4 * len(stable)


def coupled(matrices, **more):
    """A scenario of two axes, a user per impedance matrix (given by its text)."""
    of = scenario(dof=2, users=len(matrices), **more)
    users = [
        dataclasses.replace(user, master=dataclasses.replace(user.master, impedance_matrix=matrix))
        for user, matrix in zip(of.users, matrices, strict=True)
    ]
    return dataclasses.replace(of, users=tuple(users))


LATE = {"server__coupling": "one_step_delay", "device__damping": 4.0}


def test_nothing_proved_for_impedance_matrices_is_unstable_at_any_delay():
    draw = np.random.default_rng(7)
    proofs = []
    for _ in range(6):
        b = np.exp(draw.uniform(*np.log((8.0, 60.0)), size=(2, 2)))
        of = coupled(
            [turned(draw.uniform(0.0, np.pi), *own) for own in b],
            **LATE,
            master__rate_drop=2,
            server__period_s=0.002,
            server__contact_stiffness=float(np.exp(draw.uniform(*np.log((100.0, 30000.0))))),
        )
        proofs.append(any_delay(of).proved)
        for up, down in ((0, 0), (3, 1)):
            delayed = varied(of, "link.up.delay_s", up * 0.002)
            radius = float(np.max(radii(varied(delayed, "link.down.delay_s", down * 0.002))))
            assert not proofs[-1] or radius <= 1.0 + ROUNDING
    assert 0 < sum(proofs) < len(proofs)


def turned(angle, *values):
    """The text of a matrix with these eigenvalues."""
    axes = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return text_of((axes * values) @ axes.T)
