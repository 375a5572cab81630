# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rule that tells whether a port that decodes late is passive at a wall, or has to limit it.

A wall takes and returns no more than it got if and only if (backward Euler; theory: section 5)

    K T_VE + 2B <= c b + G

with c = 1 where the port decodes late, 0.85 where it learns (it repays), G = K T_VE where it uses
the learned slope, else (K T_VE <= b/2) 0. Where that does not hold the energy of decoding has to
come from somewhere: a compensation takes it from the returning waves, and the rendered wall
yields. Until a slope is learned (the first steps of the first contact) the rule is that without G.

Equations: docs/theory.md 4.9, 5.4.
"""

from typing import NamedTuple

from pmwvc_core.law.black_box.secant import REPAID, SOFT
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.couplings import COMPENSATIONS, least_impedance
from pmwvc_core.wave.impedance import smallest


class WallRule(NamedTuple):
    """K T_VE + 2B of a wall, c b + G of its port, and of that G [N s/m]."""

    needed: float
    bound: float
    slope: float

    @property
    def met(self) -> bool:
        """Tell whether the rule holds once the wall's slope is learned."""
        return self.needed <= self.bound

    @property
    def met_unlearned(self) -> bool:
        """Tell whether it holds before, too."""
        return self.needed <= self.bound - self.slope


def rule(user: User, scenario: Scenario) -> WallRule | None:
    """Return the rule of a user's port; None where none is known or needed: of a black box it is
    for a wall that does not report its slope.
    """
    server, environment = scenario.server, scenario.environment
    if server.integrator != "backward_euler":
        return None
    if scenario.coupling.black_box and (not environment.spring or environment.sloped):
        return None
    treated = COMPENSATIONS.of(server.compensation)
    alone = not scenario.coupling.black_box or treated.linear == treated.name
    if not may_limit(scenario) and not (alone and decodes_late(scenario)):
        return None
    learns = scenario.coupling.black_box and server.learns
    stiff = float(user.contact.contact_stiffness) * server.period_s
    b = smallest(user.server_impedance)
    learned = stiff if learns and stiff > SOFT * b else 0.0
    bound = (1.0 - 0.5 * REPAID if learns else 1.0) * b + learned
    return WallRule(least_impedance(server, user.contact), bound, learned)


def decodes_late(scenario: Scenario) -> bool:
    """Tell whether the ports decode with the force of the step before, and go on from there."""
    if not scenario.coupling.black_box:
        return scenario.coupling.late
    return scenario.server.decoding == "late" and not scenario.environment.sloped


def may_limit(scenario: Scenario) -> bool:
    """Tell whether the server port may shorten waves at all."""
    compensation = COMPENSATIONS.of(scenario.server.compensation)
    return scenario.coupling.black_box and compensation.limits


def limited(scenario: Scenario) -> bool | None:
    """Tell whether some environment will be limited; None where no rule is known."""
    environment = scenario.environment
    implicit = scenario.server.integrator == "backward_euler"
    if not may_limit(scenario) or (environment.spring and environment.sloped and implicit):
        return False
    rules = [rule(user, scenario) for user in scenario.users]
    if any(found is not None and not found.met for found in rules):
        return True
    return False if all(found is not None and found.met_unlearned for found in rules) else None


def lines(scenario: Scenario) -> list[str]:
    """Return a sentence for each user whose rule is not met."""
    so = "late decoding may generate energy."
    if may_limit(scenario):
        so = "the server port will limit the environment: it is softer, or the wall is lost."
    rules = [(user.name, rule(user, scenario)) for user in scenario.users]
    return [
        f"{name}: K T + 2B = {own.needed:.3g} N s/m, above {own.bound:.3g} N s/m: {so}"
        for name, own in rules
        if own is not None and not own.met
    ]
