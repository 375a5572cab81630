# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The rule that tells whether the port of a black-box environment has to limit it.

A wall takes and returns no more than it got if and only if (backward Euler; theory: section 5)

    K T_VE + 2B <= b + G

with G = 0 where it is decoded with the force of the step before, as every wall with K T_VE <= b/2
is, and G = K T_VE where the port uses the slope that it has learned. Where that does not hold the
energy of decoding has to come from somewhere: a compensation takes it from the returning waves,
and the rendered wall yields. Until a slope is learned (the first steps of the first contact) the
rule is that without G.

Equations: docs/theory.md 5.4.
"""

from typing import NamedTuple

from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.server.black_box.secant import SOFT
from pmwvc_core.server.compensations import COMPENSATIONS
from pmwvc_core.server.couplings.sampled import least_impedance
from pmwvc_core.wave.impedance import smallest


class Rule(NamedTuple):
    """K T_VE + 2B of a wall, b and G of its port [N s/m]."""

    needed: float
    b: float
    slope: float

    @property
    def met(self) -> bool:
        """Tell whether the wall is not limited once its slope is learned."""
        return self.needed <= self.b + self.slope

    @property
    def met_unlearned(self) -> bool:
        """Tell whether it is not limited before, either."""
        return self.needed <= self.b


def rule(user: User, scenario: Scenario) -> Rule | None:
    """Return the rule of a user's port that may limit; None where none is known.

    Known for a wall that does not report its slope, with backward Euler.
    """
    server = scenario.server
    environment = scenario.environment
    if not may_limit(scenario) or not environment.spring or environment.sloped:
        return None
    if server.integrator != "backward_euler":
        return None
    stiff = float(user.contact.contact_stiffness) * server.period_s
    b = smallest(user.server_impedance)
    learns = server.learns and stiff > SOFT * b
    return Rule(least_impedance(server, user.contact), b, stiff if learns else 0.0)


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
    server = scenario.server
    environment = scenario.environment
    solved = environment.spring and environment.sloped and server.integrator == "backward_euler"
    if not may_limit(scenario) or solved:
        return False
    rules = [rule(user, scenario) for user in scenario.users]
    if any(found is not None and not found.met for found in rules):
        return True
    return False if all(found is not None and found.met_unlearned for found in rules) else None


def lines(scenario: Scenario) -> list[str]:
    """Return a sentence for each user whose rule is not met."""
    found = []
    for user in scenario.users:
        own = rule(user, scenario)
        if own is None or own.met_unlearned:
            continue
        text = f"{user.name}: K T + 2B = {own.needed:.3g} N s/m"
        if own.met:
            found.append(
                f"{text}, above b = {own.b:.3g} N s/m: the server port may limit the environment "
                "until it has learned its slope; from then on it is passive, and repays the "
                "displacement."
            )
        else:
            plus = f" + G = {own.b + own.slope:.3g}" if own.slope else f" = {own.b:.3g}"
            found.append(
                f"{text}, above b{plus} N s/m: the server port will limit the environment. The "
                "rendered stiffness is then lower, or the wall is lost."
            )
    if may_limit(scenario) and any(rule(user, scenario) is None for user in scenario.users):
        if limited(scenario) is None:
            found.append("It is unknown whether the server port will limit the environment.")
    return found
