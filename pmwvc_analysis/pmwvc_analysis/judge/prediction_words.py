# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A prediction in sentences, before a session; what became of it: :mod:`.outcomes`."""

from pmwvc_analysis.judge import prediction_environment
from pmwvc_analysis.judge.prediction import (
    ALIASING_BOUND,
    Exact,
    aliasing_gain,
    exact,
    feels_as_its_lag,
    felt_stiffness,
    lag_s,
    one_step_bound,
    passive,
)
from pmwvc_analysis.models.linear import nonlinear, relative
from pmwvc_core.rivals import tuning
from pmwvc_core.simulation.scenario import Scenario
from pmwvc_core.wave import aliasing
from pmwvc_core.wave.content import has_waves
from pmwvc_core.wave.impedance import first_axis

WITHOUT_WAVES = {
    "direct": "Direct coupling: nothing keeps it passive as delay or stiffness grows.",
    "virtual_coupling": "Virtual coupling: stable where its rules are met; nobody counts energy.",
    "tdpa": "Time-domain passivity control: what the link gave out too much is damped "
    "away later; a slow device can hardly be damped.",
    "pspm": "Set-position modulation: each end spends no more energy than it has.",
}


def lines(scenario: Scenario, *, live: bool) -> list[str]:
    """Return the prediction in sentences, for a terminal and for the report."""
    found = _stability_lines(scenario, live=live)
    if not has_waves(scenario.controller):
        return [*found, WITHOUT_WAVES[scenario.controller], *_rule_lines(scenario)]
    for user in scenario.users:
        tau, b = lag_s(user, scenario, live=live), first_axis(user.impedance)
        if not feels_as_its_lag(user, scenario):
            how = "what it feels like, with local model or position feedback, pmwvc transparency "
            if nonlinear(scenario):
                how = "what it feels like is not decided by it alone, pmwvc simulate "
            found.append(
                f"{user.name}: lag of the link {tau * 1e3:.1f} ms once around; {how}tells."
            )
            continue
        free = lag_s(user, scenario, live=live, touching=False)
        limit = prediction_environment.rule(user, scenario)
        if limit is not None and not limit.met:
            found.append(
                f"{user.name}: lag of the link {tau * 1e3:.1f} ms once around; the rendered "
                "stiffness is not known."
            )
            continue
        felt = felt_stiffness(float(user.contact.contact_stiffness), b, tau)
        found.append(
            f"{user.name}: lag of the link {tau * 1e3:.1f} ms once around; it feels like a spring "
            f"of {2 * b / tau:.0f} N/m and {b * free / 2:.2f} kg in between ({felt:.0f} N/m with "
            "the contact)."
        )
    found += _aliasing_lines(scenario)
    for user in scenario.users:
        if one_step_bound(user, scenario) is False:
            found.append(f"{user.name}: K T + 2B > b: decoding a step late may give out energy.")
    found += prediction_environment.lines(scenario)
    if passive(scenario) and prediction_environment.limited(scenario) is False:
        found.append("Every part is passive: that holds at any constant delay.")
    return found


def _rule_lines(scenario: Scenario) -> list[str]:
    """Return how each user's parameters stand to the tuning rule of a controller without waves."""
    found = []
    for user in scenario.users:
        loop = tuning.loop_of(
            master=user.master,
            device=user.device,
            operator=user.operator,
            server=scenario.server,
            contact=user.contact,
            up=user.link_up,
            down=user.link_down,
        )
        checked = tuning.check(scenario.controller, user.baseline, loop)
        for rule, margin in checked.criteria.items() if checked else ():
            verdict = "met with" if margin >= 0.0 else "NOT met, short of"
            found.append(f"{user.name}: rule '{rule}' {verdict} {abs(margin):.1f} N s/m.")
    return found


def _aliasing_lines(scenario: Scenario) -> list[str]:
    """Return a warning for every filter that lets aliasing through, with its users."""
    found: dict[str, list[str]] = {}
    for user in scenario.users:
        master, gain = user.master, aliasing_gain(user)
        texts = aliasing.warnings_of(
            master.filter, tick_s=master.tick_s, rate_drop=master.rate_drop
        )
        if not texts and gain > ALIASING_BOUND:
            texts = [
                "the anti-aliasing filter is weak: in the worst case packets carry "
                f"{gain:.4g} times the energy that went in"
            ]
        for text in texts:
            found.setdefault(text, []).append(user.name)
    return [f"Warning: {', '.join(users)}: {text}." for text, users in found.items()]


def _stability_lines(scenario: Scenario, *, live: bool) -> list[str]:
    """Return what the exact model says: of the scenario, or of its linear relative."""
    model = exact(scenario, live=live)
    if model is not None:
        return [f"{_stability(model)} (hands off)."]
    elements = nonlinear(scenario)
    if not elements:
        return ["No exact model of these settings: their periods hardly ever meet."]
    said = ", ".join(dict.fromkeys(element.said for element in elements))
    found = [f"There is no exact model of what is not linear: {said}."]
    near = relative(scenario)
    likeness = exact(near.scenario, live=live) if near else None
    if near and likeness:
        found.append(
            f"The linear relative with {', '.join(near.settings)}: {_stability(likeness)}."
        )
    return found


def _stability(model: Exact) -> str:
    first, bound = model.limit.first, model.limit.bound
    if first is None:
        reach = f"no contact stiffness up to {bound:g} N/m changes that"
    elif first == 0.0:
        reach = "no contact stiffness is stable"
    else:
        reach = f"the contact may be as stiff as {first:.0f} N/m"
    word = "Stable" if model.stable else "NOT stable"
    return f"{word}: spectral radius {model.spectral_radius:.4f}; {reach}"
