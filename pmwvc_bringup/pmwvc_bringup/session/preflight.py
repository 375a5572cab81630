# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks of a scenario before anything starts: the recordings, delay traces and plug-ins it names,
and filters without a design. Works without ROS.
"""

import importlib.util
from collections.abc import Callable, Iterator
from functools import partial

from pmwvc_core.controllers.library import has_waves
from pmwvc_core.errors import PmwvcError, ScenarioError
from pmwvc_core.network import effects
from pmwvc_core.plant.hands import make_hand
from pmwvc_core.scenario.conflicts import disturbances_of
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server import environments
from pmwvc_core.simulation.conditions import place_of

# Of a core at 1 kHz: a master takes 12 to 25 %, its share of the other nodes up to 15 %.
USER_CORES, TICK_S = 0.3, 0.001


def check(scenario: Scenario) -> None:
    """Refuse a scenario that could not run: ScenarioError with every file and plug-in that cannot
    be used, each once, with its first user.
    """
    found: dict[str, str] = {}
    for user in scenario.users:
        for text in _problems(user, scenario):
            found.setdefault(text, user.name)
    problems = [f"{who}: {text}" for text, who in found.items()]
    try:
        environments.require(scenario.server.environment)
    except PmwvcError as error:
        problems.append(str(error))
    known = [name for name, record in environments.LIBRARY.items() if record.known]
    if not has_waves(scenario.controller) and not scenario.environment.known:
        problems.append(
            f"server.environment = {scenario.server.environment!r}: needs controller = pmwvc "
            f"({scenario.controller} supports only {' and '.join(known)})"
        )
    if problems:
        raise ScenarioError(scenario.name, problems)


def require_ros() -> None:
    """Refuse (PmwvcError) what needs ROS where there is none."""
    if importlib.util.find_spec("rclpy") is None:
        raise PmwvcError(
            "ROS 2 is not in this Python environment (no rclpy): run 'make setup' in the source "
            "tree, or source an installed ROS 2; only run, node and the view of a running session "
            "need it, 'pmwvc simulate' and all other commands do not"
        )


def too_much(scenario: Scenario, *, cores: int, busy: float) -> list[str]:
    """Return a warning, in a sentence, of a live session for which the cores of this machine are
    too few; ``busy`` of them have other work.
    """
    needed = len(scenario.users) * USER_CORES * TICK_S / scenario.tick_s
    if needed + busy <= cores:
        return []
    return [
        f"Warning: this session needs about {needed:.1f} cores; this machine has {cores}, with a "
        f"load of {busy:.1f}: loops will be late. End other programs, or take fewer users."
    ]


def notes(scenario: Scenario) -> list[str]:
    """Return what a simulation leaves out of the scenario, in sentences."""
    disturbed = [f"Not simulated: {one}." for one in disturbances_of(scenario.disturbances)]
    return disturbed + [
        f"{user.name}: a simulated device replaces device.plugin = {user.device.plugin!r}."
        for user in scenario.users
        if not user.device.is_simulated
    ]


def _problems(user: User, scenario: Scenario) -> Iterator[str]:
    def device() -> None:
        if importlib.util.find_spec("pmwvc_master") is not None:  # nodes and devices need ROS
            from pmwvc_master.devices import PLUGINS

            PLUGINS.required(user.device.plugin)

    def operator() -> None:
        make_hand(user.operator, scenario.task, place_of(user, scenario))

    def master() -> None:
        from pmwvc_core.made.user import made_user  # no help waits for the laws

        made_user(user, scenario)

    links = [partial(effects.check, link) for link in (user.link_up, user.link_down)]
    attempts: list[Callable[[], object]] = [operator, master, *links]
    if not user.device.is_simulated:  # that one is part of this, installed or run from source
        attempts.insert(0, device)
    for attempt in attempts:
        try:
            attempt()
        except PmwvcError as error:
            yield str(error)
