# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What makes a scenario linear, and what a linear answer leaves out."""

import numpy as np

from pmwvc_core.errors import PmwvcError
from pmwvc_core.simulation.scenario import Scenario, User


class NonlinearError(PmwvcError):
    """A linear model was asked of something that is not linear."""


def require_linear(scenario: Scenario) -> None:
    """Refuse elements that no linear model stands for.

    Raises
    ------
    NonlinearError
        Naming each, and what to use instead.
    """
    found = []
    for user in scenario.users:
        if np.any(np.asarray(user.device.friction) > 0.0):
            found.append(f"{user.name}.device.friction = {user.device.friction} N")
        if np.any(np.asarray(user.device.encoder_step_m) > 0.0):
            found.append(f"{user.name}.device.encoder_step_m = {user.device.encoder_step_m} m")
        for way, link in (("up", user.link_up), ("down", user.link_down)):
            if link.rate_limit_bps > 0.0:
                found.append(
                    f"{user.name}.link.{way}.rate_limit_bps = {link.rate_limit_bps} bit/s"
                )
    if found:
        raise NonlinearError(
            f"{scenario.name} is not linear: {', '.join(found)}; set them to 0 for the linear "
            "model, or use 'pmwvc simulate', which has them"
        )


def notes_of(scenario: Scenario) -> list[str]:
    """Return, in sentences, where the linear model stands for something else."""
    users = scenario.users
    found = []
    if any(user.contact.contact == "grip" for user in users):
        found.append("Grip contacts are taken as two-sided: the answer holds while all touch.")
    if any(user.operator.kind == "hand" or "motion" in user.operator.kind for user in users):
        found.append("Hands are given forces: their own stiffness and mass are left out.")
    if any(_random(user) for user in users):
        found.append("Jitter, loss and duplication are left out: every packet takes delay_s.")
    if scenario.dof > 1:
        found.append("One axis is analysed: all axes have the same model.")
    found.append("Limits on force, speed and workspace are taken as not reached.")
    return found


def _random(user: User) -> bool:
    return any(
        link.jitter != "none" or link.loss > 0.0 or link.duplicate > 0.0
        for link in (user.link_up, user.link_down)
    )
