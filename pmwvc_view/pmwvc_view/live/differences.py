# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The parameters in which the nodes of two scenarios differ."""

from collections.abc import Callable, Mapping
from typing import Any

from pmwvc_core.runtime.parameter_values import values_of
from pmwvc_core.scenario.scenario import Scenario


def differences(
    before: Scenario, after: Scenario, of: Callable[[Scenario], Mapping[str, Any]]
) -> dict[str, Any]:
    """Return the parameters of a node that differ."""
    old = of(before)
    return {name: value for name, value in of(after).items() if value != old[name]}


def links_of(scenario: Scenario) -> dict[str, Any]:
    """Return the parameters of the emulator's links."""
    found: dict[str, Any] = {}
    for user in scenario.users:
        found |= values_of(f"{user.name}.link.up", user.link_up)
        found |= values_of(f"{user.name}.link.down", user.link_down)
    return found


def server_of(scenario: Scenario) -> dict[str, Any]:
    """Return the parameters of the server."""
    found = values_of("server", scenario.server)
    for user in scenario.users:
        found |= values_of(f"{user.name}.server", user.contact)
    return found
