# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether the port of an unknown environment will have to limit it, from the numbers alone.

A wall that is decoded with the force of the step before takes and returns no more than it got if
and only if K T_VE + 2B <= b (backward Euler; theory: section 5). Where that does not hold the
energy of decoding has to come from somewhere: a compensation takes it from the returning waves,
and the rendered wall yields. Where it does, a spring alone or a damper alone is never limited.
"""

from typing import NamedTuple

from pmwvc_core.simulation.scenario import Scenario, User
from pmwvc_core.wave.content import has_waves
from pmwvc_core.wave.impedance import smallest

LIMITING = ("corrected", "ledger")  # compensations that shorten waves


class Rule(NamedTuple):
    """K T_VE + 2B of a wall, and the damping that it may be at most [N s/m]."""

    needed: float
    available: float

    @property
    def met(self) -> bool:
        """Tell whether the wall is not limited."""
        return self.needed <= self.available


def rule(user: User, scenario: Scenario) -> Rule | None:
    """Return the rule of a user's port that may limit; None where none is known.

    Known for a wall whose force is decoded late, with backward Euler.
    """
    server = scenario.server
    if not may_limit(scenario) or server.environment != "wall":
        return None
    if server.integrator != "backward_euler":
        return None
    stiff = float(user.contact.contact_stiffness) * server.period_s
    return Rule(stiff + 2.0 * float(user.contact.contact_damping), smallest(user.server_impedance))


def may_limit(scenario: Scenario) -> bool:
    """Tell whether the server port may shorten waves at all."""
    server = scenario.server
    unknown = has_waves(scenario.controller) and server.coupling == "unknown"
    return unknown and server.compensation in LIMITING


def limited(scenario: Scenario) -> bool | None:
    """Tell whether some environment will be limited; None where no rule is known."""
    server = scenario.server
    solved = server.environment == "wall_with_slope" and server.integrator == "backward_euler"
    if not may_limit(scenario) or solved:
        return False
    rules = [rule(user, scenario) for user in scenario.users]
    if any(found is not None and not found.met for found in rules):
        return True
    return None if None in rules else False


def lines(scenario: Scenario) -> list[str]:
    """Return a sentence for each user whose rule is not met."""
    found = []
    for user in scenario.users:
        own = rule(user, scenario)
        if own is not None and not own.met:
            found.append(
                f"{user.name}: K T + 2B = {own.needed:.3g} N s/m, above b = {own.available:.3g} "
                "N s/m: the server port will limit the environment. The rendered stiffness is "
                "then lower, or the wall is lost."
            )
    if limited(scenario) is None:
        found.append("Whether the server port will have to limit the environment is not known.")
    return found
