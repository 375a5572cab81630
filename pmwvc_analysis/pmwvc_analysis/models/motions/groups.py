# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Equal users make small problems of a large one.

The motion of g equal users is the mean motion, in which they act on the object as one user with g
times the force, and g - 1 motions against one another, in which their forces cancel: the object
stays, and each of them has the eigenvalues of one user at a wall. So the eigenvalues of the whole
loop are those of one user for each group, weighted, and of one user at a wall for each group of
several. Side, hand and limits do not matter here. (A cube behind a port that does not know it is
not resolved like a wall, and code of another package may treat users by their order: there, users
are left apart.)
"""

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.models.linear import outside
from pmwvc_core.scenario.scenario import Scenario, User

COMPARED_FIELDS = ("master", "baseline", "device", "contact", "link_up", "link_down")


class Subproblem(NamedTuple):
    """A smaller problem: a scenario, and how many users each of its users stands for."""

    scenario: Scenario
    weights: tuple[int, ...]


def subproblems(scenario: Scenario) -> list[Subproblem]:
    """Return smaller problems with, together, all eigenvalues of a scenario."""
    groups: list[list[User]] = []
    unknown_cube = scenario.coupling.black_box and scenario.environment.movable
    apart = unknown_cube or outside(scenario)
    for user in scenario.users:
        for group in groups:
            if not apart and all(
                _equal(getattr(user, name), getattr(group[0], name)) for name in COMPARED_FIELDS
            ):
                group.append(user)
                break
        else:
            groups.append([user])
    # What is done to nodes names users, of which there are fewer here.
    scenario = dataclasses.replace(scenario, disturbances="")
    together = dataclasses.replace(scenario, users=tuple(group[0] for group in groups))
    wall = scenario.server
    if scenario.environment.movable:  # a wall is kept: a slope it reports is part of its law
        wall = dataclasses.replace(wall, environment="wall")
    found = [Subproblem(together, tuple(len(group) for group in groups))]
    for group in groups:
        if len(group) > 1:
            alone = dataclasses.replace(scenario, users=(group[0],), server=wall)
            found.append(Subproblem(alone, (1,)))
    return found


def _equal(left: Any, right: Any) -> bool:
    """Compare parameters that may hold columns."""
    if left is right:
        return True
    if dataclasses.is_dataclass(left):
        return all(
            _equal(getattr(left, field.name), getattr(right, field.name))
            for field in dataclasses.fields(left)
        )
    return bool(np.array_equal(left, right))
