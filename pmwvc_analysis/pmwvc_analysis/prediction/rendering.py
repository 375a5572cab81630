# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a user's link renders, in sentences: its lag as a spring and a mass
(:mod:`pmwvc_analysis.prediction.lag`).
"""

import math

from pmwvc_analysis.prediction import environment, lag
from pmwvc_core.network.effects import is_random
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.impedance import MatrixImpedance, first_axis


def round_trip_words(user: User, scenario: Scenario, *, live: bool) -> str:
    """Return the round trip of a user's waves in words, and by how much its avatar leads."""
    lead = lag.lead_s(scenario)
    tau = lag.lag_s(user, scenario, live=live) + lead
    drawn = is_random(user.link_up) or is_random(user.link_down)
    text = f"round trip {tau * 1e3:.1f} ms"
    text += " (expected; jitter and loss decide it)" if drawn else ""
    if not lead:
        return text
    return f"{text}, less {lead * 1e3:.1f} ms: its avatar moves by the force of the step before"


def link_words(user: User, scenario: Scenario, *, live: bool) -> str:
    """Return what the lag is rendered as, in words: a spring and a mass."""
    tau, b = lag.lag_s(user, scenario, live=live), first_axis(user.in_contact.impedance)
    mass = lag.rendered_mass(user, scenario, live=live)
    stiffness = lag.rendered_stiffness(user, tau)
    whole = mass + float(user.device.mass)
    if tau > 0.0:
        return (
            f"the link acts like a spring of {2.0 * b / tau:.0f} N/m and a mass of {mass:.2f} kg "
            f"(rendered stiffness {stiffness:.0f} N/m, mass with the device {whole:.2f} kg)"
        )
    behind = f"the device stands {-tau / (2.0 * b) * 1e3:.2f} mm per newton behind its avatar"
    return f"{behind}; nothing touched, the link acts like a mass of {mass:.2f} kg"


def rendering_lines(user: User, scenario: Scenario, *, live: bool) -> list[str]:
    """Return the lag of a user's link, and the spring and the mass that it is rendered as."""
    head = f"{user.name}: {round_trip_words(user, scenario, live=live)}"
    if not lag.lag_decides(user, scenario):
        command = "use 'pmwvc transparency'"
        return [f"{head}; it alone does not decide the rendered stiffness: {command}."]
    if environment.limited(scenario):
        return [f"{head}; the rendered stiffness is not known."]
    found = [f"{head}; {link_words(user, scenario, live=live)}."]
    if isinstance(user.impedance, MatrixImpedance):
        found.append(f"{user.name}: this is for forces along axis 1.")
    scale = math.sqrt(lag.transformer(user))
    if abs(scale - 1.0) > lag.RATIO_TOLERANCE:
        found.append(
            f"{user.name}: the ends have different impedance: the device moves {scale:.3g} "
            f"times as far as its avatar, with 1/{scale:.3g} of its force."
        )
    return found
