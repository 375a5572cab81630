# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rule that tells whether the port of a black-box environment has to limit it.

A wall takes and returns no more than it got if and only if (backward Euler; theory: section 5)

    K T_VE + 2B <= c b + G

with c = 1 where the port decodes late, 0.85 where it learns (it repays), G = K T_VE where it uses
the learned slope, else (K T_VE <= b/2) 0. Where that does not hold the energy of decoding has to
come from somewhere: a compensation takes it from the returning waves, and the rendered wall
yields. Until a slope is learned (the first steps of the first contact) the rule is that without G.

Equations: docs/theory.md 5.4.
"""

from typing import NamedTuple

from pmwvc_core.law.black_box.secant import REPAID, SOFT
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.couplings import COMPENSATIONS, least_impedance
from pmwvc_core.wave.impedance import smallest

MAY_LIMIT = (
    "may limit the environment until it has learned its slope; from then on it is passive, and "
    "repays the displacement."
)
WILL_LIMIT = (
    "will limit the environment. The rendered stiffness is then lower, or the wall is lost."
)


class WallRule(NamedTuple):
    """K T_VE + 2B of a wall, and b, c and G of its port [N s/m]."""

    needed: float
    b: float
    share: float
    slope: float

    @property
    def met(self) -> bool:
        """Tell whether the wall is not limited once its slope is learned."""
        return self.needed <= self.share * self.b + self.slope

    @property
    def met_unlearned(self) -> bool:
        """Tell whether it is not limited before, either."""
        return self._replace(slope=0.0).met

    @property
    def bound(self) -> str:
        """State c b + G with its value."""
        name = f"{self.share:.2g} b" if self.share < 1.0 else "b"
        plus = " + G" if self.slope else ""
        return f"{name}{plus} = {self.share * self.b + self.slope:.3g} N s/m"


def rule(user: User, scenario: Scenario) -> WallRule | None:
    """Return the rule of a user's port that may limit; None where none is known: it is for a wall
    that does not report its slope, with backward Euler.
    """
    server, environment = scenario.server, scenario.environment
    reported = not environment.spring or environment.sloped
    if not may_limit(scenario) or reported or server.integrator != "backward_euler":
        return None
    stiff = float(user.contact.contact_stiffness) * server.period_s
    b = smallest(user.server_impedance)
    share = 1.0 - 0.5 * REPAID if server.learns else 1.0
    learned = stiff if server.learns and stiff > SOFT * b else 0.0
    return WallRule(least_impedance(server, user.contact), b, share, learned)


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
    rules = [(user.name, rule(user, scenario)) for user in scenario.users]
    found = []
    for name, own in rules:
        if own is None or own.met_unlearned:
            continue
        bound = (own._replace(slope=0.0) if own.met else own).bound
        words = MAY_LIMIT if own.met else WILL_LIMIT
        needed = f"K T + 2B = {own.needed:.3g} N s/m, above {bound}"
        found.append(f"{name}: {needed}: the server port {words}")
    if limited(scenario) is None and any(own is None for _, own in rules):
        found.append("It is unknown whether the server port will limit the environment.")
    return found
