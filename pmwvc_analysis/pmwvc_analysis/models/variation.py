# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenarios with other numbers, and the smaller problems that a large one comes apart into.

Scenarios are stepped side by side where they do not differ in what decides when things happen
(delays, periods, counts, names).

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

import copy
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from pmwvc_analysis.models.linear import axes_of, outside
from pmwvc_core.params import LinkParams
from pmwvc_core.scenario.names import resolved, spec_of
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.impedance import ROUNDING, MatrixImpedance

TIMES = ("delay_s", "tick_s", "period_s")  # numbers that decide when things happen
COMPARED = ("master", "baseline", "own", "device", "contact", "link_up", "link_down")
Runs = tuple[Scenario, ...]
T = TypeVar("T")


def stackable(name: str) -> bool:
    """Tell whether a parameter may differ side by side; ScenarioError where there is none."""
    group, _, leaf = resolved(name)[1][0].rpartition(".")
    return bool(group) and spec_of(name).kind is float and leaf not in TIMES


def changed(parameters: T, **values: Any) -> T:
    """Return parameters with other values, which need no check."""
    found = copy.copy(parameters)
    vars(found).update(values)
    return found


def with_stiffness(scenario: Scenario, stiffness: float) -> Scenario:
    """Return the scenario with another stiffness [N/m] of the stiffest contact, the others in
    proportion.
    """
    values = [float(user.contact.contact_stiffness) for user in scenario.users]
    users, top = [], max(values)
    for user, value in zip(scenario.users, values, strict=True):
        own = float(stiffness) * (value / top if top > 0.0 else 1.0)
        users.append(changed(user, contact=changed(user.contact, contact_stiffness=own)))
    return changed(scenario, users=tuple(users))


def with_links(scenario: Scenario, links: Sequence[tuple[LinkParams, LinkParams]]) -> Scenario:
    """Return the scenario with other links of each user, up and down."""
    users = tuple(
        changed(user, link_up=up, link_down=down)
        for user, (up, down) in zip(scenario.users, links, strict=True)
    )
    return changed(scenario, users=users)


def with_impedances(user: User, master: float, server: float | None) -> User:
    """Return a user with numbers as impedances of both ends, None: that of the other [N s/m]."""
    none: dict[str, Any] = {"impedance_matrix": ""}
    return changed(
        user,
        master=changed(user.master, impedance=master, **none),
        contact=changed(user.contact, impedance=server, **none),
    )


class Subproblem(NamedTuple):
    """A smaller problem: scenarios, and how many users each of their users stands for."""

    runs: Runs
    weights: tuple[int, ...]


def subproblems(*runs: Scenario) -> list[Subproblem]:
    """Return smaller problems with, together, all eigenvalues of every scenario."""
    found = []
    for single in _along_axes(runs):
        groups = groups_of(single)
        found.append(together(single, groups))
        for group in groups:
            if len(group) > 1:
                alone, _ = together(single, [group])
                found.append(Subproblem(tuple(map(_at_wall, alone)), (1,)))
    return found


def _at_wall(scenario: Scenario) -> Scenario:
    """Return a scenario with a wall; one that there is stays: a slope it reports is in its law."""
    if not scenario.environment.movable:
        return scenario
    return changed(scenario, server=changed(scenario.server, environment="wall"))


def _along_axes(runs: Runs) -> list[Runs]:
    """Return scenarios along each principal axis, equal ones once, or themselves: none shared."""
    if axes_of(runs[0]) == 1:
        return [runs]
    axes = [_by_axis(run) for run in runs]
    return list(zip(*axes, strict=True)) if len(set(map(len, axes))) == 1 else [runs]


def _by_axis(scenario: Scenario) -> list[Scenario]:
    dof, users = axes_of(scenario), scenario.users
    ends = [b for user in users for b in (user.impedance, user.server_impedance)]
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
            found.append(changed(scenario, users=own))
    return found


def groups_of(runs: Runs, marks: Sequence[object] = ()) -> list[list[int]]:
    """Return the numbers of users that are equal in every run (and their marks), by group."""
    first, marks = runs[0], marks or [None] * len(runs[0].users)
    unknown_cube = first.coupling.black_box and first.environment.movable
    apart = unknown_cube or bool(outside(first))

    def alike(i: int, j: int) -> bool:
        pairs = ((run.users[i], run.users[j]) for run in runs)
        return marks[i] == marks[j] and all(
            getattr(one, name) == getattr(other, name) for one, other in pairs for name in COMPARED
        )

    groups: list[list[int]] = []
    for i in range(len(first.users)):
        group = next((group for group in groups if not apart and alike(i, group[0])), None)
        if group is None:
            groups.append([i])
        else:
            group.append(i)
    return groups


def together(runs: Runs, groups: Sequence[Sequence[int]]) -> Subproblem:
    """Return the motion in which the users of a group are one."""
    # What is done to nodes names users, of which there are fewer here.
    fewer = (
        changed(run, users=tuple(run.users[group[0]] for group in groups), disturbances="")
        for run in runs
    )
    return Subproblem(tuple(fewer), tuple(map(len, groups)))
