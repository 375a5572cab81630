# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A prediction in sentences, before a session; what became of it: :mod:`.outcomes`."""

import math

from pmwvc_analysis.budget.energy import declared_storage_j
from pmwvc_analysis.models.linear import left_out, nonlinear
from pmwvc_analysis.prediction import prediction_environment
from pmwvc_analysis.prediction.encoder_noise import encoder_noise_w
from pmwvc_analysis.prediction.prediction import (
    ALIASING_BOUND,
    Answer,
    Exact,
    aliasing_gain,
    answer,
    one_step_bound,
)
from pmwvc_analysis.prediction.prediction_lag import (
    SAME,
    feels_as_its_lag,
    lag_s,
    rendered_stiffness,
    transformer,
)
from pmwvc_core.baselines import tuning
from pmwvc_core.controllers import has_waves, proofs_hold, record_of
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.design import aliasing
from pmwvc_core.wave.impedance import first_axis


def lines(scenario: Scenario, *, live: bool) -> list[str]:
    """Return the prediction in sentences, for a terminal and for the report."""
    known = answer(scenario, live=live)
    found = _stability_lines(scenario, known)
    found += [f"Not modelled: {effect}." for effect in left_out(scenario)]
    if not proofs_hold(scenario.controller):
        return [*found, record_of(scenario.controller).words, *_rule_lines(scenario)]
    for user in scenario.users:
        tau, b = lag_s(user, scenario, live=live), first_axis(user.impedance)
        if not feels_as_its_lag(user, scenario):
            command = "simulate" if nonlinear(scenario) else "transparency"
            found.append(
                f"{user.name}: round trip {tau * 1e3:.1f} ms; it alone does not decide the "
                f"rendered stiffness: use 'pmwvc {command}'."
            )
            continue
        free = lag_s(user, scenario, live=live, touching=False)
        limit = prediction_environment.rule(user, scenario)
        if limit is not None and not limit.met:
            found.append(
                f"{user.name}: round trip {tau * 1e3:.1f} ms; the rendered stiffness is not known."
            )
            continue
        felt = rendered_stiffness(user, tau)
        found.append(
            f"{user.name}: round trip {tau * 1e3:.1f} ms; the link feels like a spring of "
            f"{2 * b / tau:.0f} N/m and a mass of {b * free / 2:.2f} kg (rendered stiffness "
            f"{felt:.0f} N/m)."
        )
        scale = math.sqrt(transformer(user))
        if abs(scale - 1.0) > SAME:
            found.append(
                f"{user.name}: the ends have different impedance: the device moves {scale:.3g} "
                f"times as far as its avatar, with 1/{scale:.3g} of its force."
            )
    found += _aliasing_lines(scenario)
    for user in scenario.users:
        if one_step_bound(user, scenario) is False:
            found.append(f"{user.name}: K T + 2B > b: late decoding may generate energy.")
    found += prediction_environment.lines(scenario)
    return found + _delay_lines(known) + _device_lines(scenario)


def _delay_lines(known: Answer) -> list[str]:
    """Return what is proved for any constant delay, with its condition or why it is not."""
    proof = known.at_any_delay
    if proof is None:
        return []
    if known.proved:
        where = "while all contacts touch" if proof.touching else "in contact and free"
        at = f"; the gain around the loop is at most {proof.gain:.6f}" if proof.gain else ""
        return [f"Stable at any constant delay, hands off, {where}{at}."]
    reasons = [*proof.reasons]
    if proof.proved:
        reasons = ["the server port will limit its environment, or that is not known"]
        if known.limited is False:
            reasons = ["the nearest linear scenario is not stable"]
    return [f"Not proved stable at any constant delay: {'; '.join(reasons)}."]


def rule_loop(user: User, scenario: Scenario) -> tuning.Loop:
    """Return what the tuning rules have to know of one user of a scenario."""
    return tuning.loop_of(
        master=user.master,
        device=user.device,
        operator=user.operator,
        server=scenario.server,
        contact=user.contact,
        up=user.link_up,
        down=user.link_down,
    )


def _rule_lines(scenario: Scenario) -> list[str]:
    """Return how each user's parameters stand to the tuning rule of a controller without waves."""
    found = []
    for user in scenario.users:
        loop = rule_loop(user, scenario)
        checked = record_of(scenario.controller).check(user.baseline, loop)
        for rule, margin in checked.criteria.items() if checked else ():
            verdict = "met, margin" if margin >= 0.0 else "NOT met, deficit"
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


def _stability_lines(scenario: Scenario, known: Answer) -> list[str]:
    """Return what the exact model says: of the scenario, or of its linear relative."""
    if known.exact is not None:
        return [f"{_stability(known.exact)} (hands off)."]
    said = ", ".join(dict.fromkeys(element.said for element in nonlinear(scenario)))
    if known.near is None and said:
        return [f"No exact model, not linear: {said}. No linear scenario is near."]
    if known.near is None:
        return [
            "No exact model of these settings: the hyperperiod of frames and server steps is too "
            "long."
        ]
    found = [f"No exact model, not linear: {said}."]
    if known.likeness is not None:
        found.append(
            f"The nearest linear scenario, with {', '.join(known.near.settings)}: "
            f"{_stability(known.likeness)}."
        )
    return found


def _stability(model: Exact) -> str:
    first, bound = model.limit.first, model.limit.bound
    if first is None:
        reach = f"at every contact stiffness up to {bound:g} N/m"
    elif first == 0.0:
        reach = "no contact stiffness is stable"
    else:
        reach = f"largest stable contact stiffness {first:.0f} N/m"
    word = "Stable" if model.stable else "NOT stable"
    return f"{word}: spectral radius {model.spectral_radius:.5g}; {reach}"


def _device_lines(scenario: Scenario) -> list[str]:
    """Return what a port gives out by declaration, and what an encoder adds."""
    found = []
    for user in scenario.users:
        if (stored := declared_storage_j(scenario.controller, user)) > 0.0:
            found.append(f"{user.name}: declared storage {1e3 * stored:.3g} mJ.")
        noise_w = encoder_noise_w(user) if has_waves(scenario.controller) else 0.0
        if noise_w > 0.0:
            found.append(
                f"{user.name}: where a grip trembles over the counts of its encoder, the waves "
                f"carry {1e3 * noise_w:.2g} mW of noise that no hand gives; the port of the hand "
                "is not passive by as much."
            )
    return found
