# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A law on many elements gives what it gives for each by itself, whatever they decide."""

import numpy as np
import pytest
from support import linear_loops

from pmwvc_analysis.models import elements
from pmwvc_analysis.models.elements import UnlikeError, as_columns, leaves, lifted, stacked
from pmwvc_analysis.models.ends import PerturbedUser, Slot
from pmwvc_analysis.models.matrices import ends_of

COUNT, TICKS = 5, 240
ENDS = [
    {},
    {"device__damping": 0.4, "master__velocity_filter__kind": "exact"},
    {"channel": "strict", "link__delay_s": 0.011},
    {"controller": "direct", "server__coupling": "implicit"},
    {"server__coupling": "unwrapped", "users": 3},
    {
        "server__coupling": "unknown",
        "server__environment": "cube",
        "server__compensation": "none",
        "server__decoding": "late",
    },
]


def pushed(scenario, forces, *, edges, of=lifted):
    """Return the numbers of all ends under forces ``(ticks, users, elements)``, and as large waves
    in the packets, with friction, stops and limits that some of the elements reach: these decide
    otherwise than the rest.
    """
    limits = {"max_force": 2.0, "slew": 0.6, "damper_velocity": 0.15, "fault_velocity": 3.0}
    numbers = {}

    def vector(values):
        return (elements.elements(values) if len(values) > 1 else float(values[0]),)

    for (kind, *given), runs in ends_of([scenario], False):
        end = kind(runs, *given)
        if kind is PerturbedUser:
            p, device = end.p
            p = p._replace(limits=p.limits._replace(**limits)) if edges else p
            end.p = p, device._replace(friction=0.05, reach_m=0.03)
        _, *others = end.nothing
        came = {
            Slot(way, packet): (vector(0.1 * row[way]), *others)
            for packet, row in enumerate(forces)
            for way in range(len(end.ways))
        }
        for tick, row in enumerate(forces):
            end.step(tick, came, vector(row[0]), of)
        numbers |= {(end.name, *path): value for path, value in leaves(end.s).items()}
    return numbers


@pytest.mark.parametrize("values", ENDS)
@pytest.mark.parametrize("edges", [False, True])
def test_elements_together_are_those_alone(values, edges):
    scenario = linear_loops.scenario(**values)
    rng = np.random.default_rng(len(values) + edges)
    strength = np.array([0.0, 0.2, 1.0, 4.0, -3.0])
    steps = rng.choice([-1.0, 0.0, 1.0], (TICKS // 20, len(scenario.users), COUNT))
    forces = np.repeat(steps, 20, axis=0) * strength
    together = pushed(scenario, forces, edges=edges)
    for one in range(COUNT):
        alone = pushed(scenario, forces[..., one : one + 1], edges=edges, of=lambda law: law)
        assert alone.keys() == together.keys()
        for path, value in alone.items():
            found = as_columns(together[path], 1, COUNT)[0] if np.ndim(together[path]) else None
            known = together[path] if found is None else found[one]
            np.testing.assert_allclose(known, value, rtol=1e-9, atol=1e-12, err_msg=str(path))


def lengthened(x):
    """A law that returns more for some elements."""
    return (x, x) if x > 0.0 else (x,)


def test_what_has_no_common_form_is_refused_by_the_name_of_its_law():
    lengthened.__module__ = "pmwvc_core.law.test"
    with pytest.raises(UnlikeError, match="lengthened decides by its signals"):
        lifted(lengthened)(elements.elements(np.array([1.0, -1.0])))


def test_equal_numbers_of_runs_stay_numbers():
    assert stacked([(1.0, (2.0, 3)), (1.0, (2.0, 3))]) == (1.0, (2.0, 3))
    _, (other, _) = stacked([(1.0, (2.0, 3)), (1.0, (4.0, 3))])
    assert other.tolist() == [2.0, 4.0]
