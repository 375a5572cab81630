# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Equal users and equal axes make small problems of a large one.

The motion of g equal users is the mean motion, in which they act on the object as one user with g
times the force, and g - 1 motions against one another, in which their forces cancel: the object
stays, and each of them has the eigenvalues of one user at a wall. So the eigenvalues of the whole
loop are those of one user for each group, weighted, and of one user at a wall for each group of
several. Side, hand and limits do not matter here. (A cube behind a port that does not know it is
not resolved like a wall, and code of another package may treat users by their order: there, users
are left apart.)

Axes are coupled by impedance matrices alone. Along principal axes that all of them share each is a
problem by itself, with the eigenvalues in place of the matrices; equal ones are one problem.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.models.linear import axes_of, outside
from pmwvc_analysis.models.variation import with_impedances
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.wave.impedance import ROUNDING, MatrixImpedance

COMPARED_FIELDS = ("master", "baseline", "own", "device", "contact", "link_up", "link_down")


class Subproblem(NamedTuple):
    """A smaller problem: a scenario, and how many users each of its users stands for."""

    scenario: Scenario
    weights: tuple[int, ...]


def subproblems(scenario: Scenario) -> list[Subproblem]:
    """Return smaller problems with, together, all eigenvalues of a scenario."""
    wall, found = scenario.server, []
    if scenario.environment.movable:  # a wall is kept: a slope it reports is part of its law
        wall = dataclasses.replace(wall, environment="wall")
    for single in _along_axes(scenario):
        groups = groups_of(single)
        found.append(together(single, groups))
        for group in groups:
            if len(group) > 1:
                alone, _ = together(single, [group])
                found.append(Subproblem(dataclasses.replace(alone, server=wall), (1,)))
    return found


def _along_axes(scenario: Scenario) -> list[Scenario]:
    """Return the scenario along each principal axis, equal ones once; the scenario itself where an
    axis is all there is or the impedances share none.
    """
    dof, users = axes_of(scenario), scenario.users
    ends = [b for user in users for b in (user.impedance, user.server_impedance)]
    if dof == 1 or any(np.ndim(b) for b in ends if not isinstance(b, MatrixImpedance)):
        return [scenario]
    matrices = [
        b.matrix if isinstance(b, MatrixImpedance) else float(b) * np.eye(dof) for b in ends
    ]
    mixed = sum(np.sqrt(2.0 + k) * matrix for k, matrix in enumerate(matrices))
    axes = np.linalg.eigh(mixed).eigenvectors  # shared by all of them, where they share any
    turned = [axes.T @ matrix @ axes for matrix in matrices]
    if any(np.abs(b - np.diag(np.diag(b))).max() > ROUNDING * np.abs(b).max() for b in turned):
        return [scenario]
    along = np.stack([np.diag(b) for b in turned], axis=1).reshape(dof, -1, 2)
    found = []
    for k, impedances in enumerate(along):  # (users, 2), at master and server [N s/m]
        if not np.isclose(impedances, along[:k], rtol=ROUNDING).all(axis=(1, 2)).any():
            pairs = zip(users, impedances.tolist(), strict=True)
            own = tuple(with_impedances(user, *both) for user, both in pairs)
            found.append(dataclasses.replace(scenario, users=own))
    return found


def groups_of(scenario: Scenario, marks: Sequence[object] = ()) -> list[list[int]]:
    """Return the numbers of users that are equal (and their marks), group by group."""
    users, marks = scenario.users, marks or [None] * len(scenario.users)
    unknown_cube = scenario.coupling.black_box and scenario.environment.movable
    apart = unknown_cube or bool(outside(scenario))

    def alike(i: int, j: int) -> bool:
        pairs = ((getattr(users[i], name), getattr(users[j], name)) for name in COMPARED_FIELDS)
        return not apart and marks[i] == marks[j] and all(_equal(*pair) for pair in pairs)

    groups: list[list[int]] = []
    for i in range(len(users)):
        group = next((group for group in groups if alike(i, group[0])), None)
        if group is None:
            groups.append([i])
        else:
            group.append(i)
    return groups


def together(scenario: Scenario, groups: Sequence[Sequence[int]]) -> Subproblem:
    """Return the motion in which the users of a group are one."""
    users = tuple(scenario.users[group[0]] for group in groups)
    # What is done to nodes names users, of which there are fewer here.
    fewer = dataclasses.replace(scenario, users=users, disturbances="")
    return Subproblem(fewer, tuple(map(len, groups)))


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
