# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A law on many elements gives what it gives for each by itself, whatever they decide."""

import numpy as np
import pytest
from support import linear_loops

from pmwvc_analysis.models import elements, loop
from pmwvc_analysis.models.elements import UnlikeError, as_columns, leaves, lifted, stacked

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


def pushed(scenario, forces, *, edges):
    """Return the numbers of both ends under forces ``(ticks, users, elements)`` with friction,
    stops and limits that some of the elements reach: these decide otherwise than the rest.
    """
    made = loop.LinearLoop(scenario)
    limits = {"max_force": 2.0, "slew": 0.6, "damper_velocity": 0.15, "fault_velocity": 3.0}
    loops, devices = list(made.p.loops), list(made.p.devices)
    for i in range(len(loops)):
        if edges:
            loops[i] = loops[i]._replace(limits=loops[i].limits._replace(**limits))
        devices[i] = devices[i]._replace(friction=0.05, reach_m=0.03)
    made.p = made.p._replace(loops=tuple(loops), devices=tuple(devices))
    for tick, row in enumerate(forces):
        made.advance(tick, [(elements.elements(f) if len(f) > 1 else float(f[0]),) for f in row])
    return leaves(made.s)


@pytest.mark.parametrize("values", ENDS)
@pytest.mark.parametrize("edges", [False, True])
def test_elements_together_are_those_alone(monkeypatch, values, edges):
    scenario = linear_loops.scenario(**values)
    rng = np.random.default_rng(len(values) + edges)
    strength = np.array([0.0, 0.2, 1.0, 4.0, -3.0])
    steps = rng.choice([-1.0, 0.0, 1.0], (TICKS // 20, len(scenario.users), COUNT))
    forces = np.repeat(steps, 20, axis=0) * strength
    together = pushed(scenario, forces, edges=edges)
    monkeypatch.setattr(loop, "LIFTED", loop.AT_REST)
    for one in range(COUNT):
        alone = pushed(scenario, forces[..., one : one + 1], edges=edges)
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
