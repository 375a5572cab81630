# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What a user's link renders, in sentences: its lag as a spring and a mass, and slow presses.

A press x(t) on a contact of stiffness K takes K tau (K/K_most - 1) times the integral of xd^2 from
the loan of the position feedback on the strict channel, with K_most = sqrt(2b) K_p; nothing up to
K_most. K_p is the largest that it adapts to. The press named is a raised cosine of ``FORCE_N`` in
``PRESS_S``, for which that integral is pi^2 F^2/(2 K^2 T).

Equations: docs/theory.md 17.17; of the lag: :mod:`pmwvc_analysis.prediction.lag`.
"""

import math

from pmwvc_analysis.prediction import environment, lag
from pmwvc_core.law.position.error import ADAPTED
from pmwvc_core.law.position.feedback import MOST
from pmwvc_core.network.effects import is_random
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.impedance import MatrixImpedance, first_axis, largest, smallest

FORCE_N, PRESS_S = 1.0, 2.5


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
    """Return what the lag is rendered as, in words: a spring and a mass; where the avatar leads by
    more than the waves lag, what the device renders instead.
    """
    tau, b = lag.lag_s(user, scenario, live=live), first_axis(user.in_contact.impedance)
    mass = lag.rendered_mass(user, scenario, live=live)
    stiffness, contact = lag.rendered_stiffness(user, tau), float(user.contact.contact_stiffness)
    whole = mass + float(user.device.mass)
    if tau > 0.0:
        return (
            f"the link acts like a spring of {2.0 * b / tau:.0f} N/m and a mass of {mass:.2f} kg "
            f"(rendered stiffness {stiffness:.0f} N/m, mass with the device {whole:.2f} kg)"
        )
    behind = f"the device stands {-tau / (2.0 * b) * 1e3:.2f} mm per newton behind its avatar"
    rendered = f"renders {stiffness:.0f} N/m, the contact {contact:.0f} N/m"
    if not 0.0 < stiffness < math.inf:
        rendered = f"its rendered stiffness is not known (contact {contact:.0f} N/m)"
    return f"{behind} and {rendered}; nothing touched, the link acts like a mass of {mass:.2f} kg"


def rendering_lines(user: User, scenario: Scenario, *, live: bool) -> list[str]:
    """Return the lag of a user's link, and the spring and the mass that it is rendered as."""
    head = f"{user.name}: {round_trip_words(user, scenario, live=live)}"
    if not lag.lag_decides(user, scenario):
        command = "use 'pmwvc transparency'"
        return [f"{head}; it alone does not decide the rendered stiffness: {command}."]
    limit = environment.rule(user, scenario)
    if limit is not None and not limit.met:
        return [f"{head}; the rendered stiffness is not known."]
    found = [f"{head}; {link_words(user, scenario, live=live)}."]
    tau = lag.lag_s(user, scenario, live=live)
    if isinstance(user.impedance, MatrixImpedance) and tau > 0.0:
        free = lag.lag_s(user, scenario, live=live, touching=False)
        least, most = smallest(user.impedance), largest(user.impedance)
        found.append(
            f"{user.name}: this is for forces along axis 1; along the principal axes of the "
            f"impedance matrix springs of {2 * least / tau:.0f} to {2 * most / tau:.0f} N/m and "
            f"masses of {least * free / 2:.2f} to {most * free / 2:.2f} kg."
        )
    scale = math.sqrt(lag.transformer(user))
    if abs(scale - 1.0) > lag.RATIO_TOLERANCE:
        found.append(
            f"{user.name}: the ends have different impedance: the device moves {scale:.3g} "
            f"times as far as its avatar, with 1/{scale:.3g} of its force."
        )
    return found


def press_lines(user: User, scenario: Scenario, *, live: bool) -> list[str]:
    """Return what becomes of a user's loan in slow presses; nothing without one."""
    position = user.master.position
    lent_j = float(position.storage_j)
    if not (scenario.strict and position.is_on and lent_j > 0.0) or scenario.coupling.black_box:
        return []
    tau_s, b = lag.lag_s(user, scenario, live=live), first_axis(user.in_contact.impedance)
    if tau_s <= 0.0:  # its avatar leads by more than the waves lag: nothing is to be paid
        return []
    most = math.sqrt(2.0 * b) * float(position.gain)
    if position.adapts:
        most = MOST * ADAPTED * 2.0 * b / tau_s
    stiffness = float(user.contact.contact_stiffness)
    head = f"{user.name}: slow presses on the contact of {stiffness:.0f} N/m"
    if stiffness <= most:
        return [
            f"{head} leave a part of the loan of {1e3 * lent_j:.3g} mJ (up to {most:.0f} N/m)."
        ]
    taken_j = math.pi**2 * FORCE_N**2 * tau_s * (stiffness / most - 1.0)
    taken_j /= 2.0 * stiffness * PRESS_S
    return [
        f"{head} use the loan of {1e3 * lent_j:.3g} mJ up (beyond {most:.0f} N/m): one of "
        f"{FORCE_N:g} N in {PRESS_S:g} s takes {1e3 * taken_j:.2g} mJ, so it lasts for about "
        f"{lent_j / taken_j:.0f}; the device then stands ahead of its avatar again, and the port "
        "stays passive."
    ]
