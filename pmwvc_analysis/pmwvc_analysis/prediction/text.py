# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The prediction for a session in sentences.

Its comparison with the recorded session: :mod:`pmwvc_analysis.verdicts.outcomes`.

On the strict channel :mod:`pmwvc_core.master.count_bound` bounds what the port of a hand releases
behind a coarse encoder.
"""

import math
from collections.abc import Mapping, Sequence

from pmwvc_analysis.budget.criterion import behind_counts, held
from pmwvc_analysis.budget.energy import declared_j
from pmwvc_analysis.models.answer import Exact
from pmwvc_analysis.models.linear import left_out, nonlinear, outside_words
from pmwvc_analysis.prediction import environment, lag, prediction
from pmwvc_core.controllers.library import proofs_hold, record_of
from pmwvc_core.controllers.record import loop_of
from pmwvc_core.master.count_bound import count_bound
from pmwvc_core.network.effects import active, is_random
from pmwvc_core.params import MasterParams
from pmwvc_core.params.names import flattened
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave import aliasing
from pmwvc_core.wave.impedance import MatrixImpedance, first_axis

STRICT = (
    "The channel is passive at any delay, jitter and loss, by its account of every packet "
    "(channel = strict); no stability margin over delay is computed."
)


def lines(scenario: Scenario, *, live: bool) -> list[str]:
    """Return the prediction in sentences, for a terminal and for the report."""
    known, users = prediction.answer(scenario, live=live), scenario.users
    found = _stability_lines(scenario, known) + outside_words(scenario)
    found += [f"Not modelled: {effect}." for effect in left_out(scenario)]
    if scenario.changes:
        found.append(f"For the parameters at the start; later changes: {scenario.changes}.")
    if not proofs_hold(scenario.controller):
        return [*found, record_of(scenario.controller).words, *_rule_lines(scenario)]
    if lag.lag_is_known(scenario):
        found += [line for user in users for line in rendering_lines(user, scenario, live=live)]
    else:
        found.append(scenario.coupling.words)
    found += _no_effect_lines(scenario) if scenario.strict else _aliasing_lines(scenario)
    found += environment.lines(scenario)
    found += [STRICT] if scenario.strict else _delay_lines(known)
    stored_mj = {user.name: 1e3 * declared_j(scenario, user) for user in users}
    found += [f"{name}: declared storage {mj:.3g} mJ." for name, mj in stored_mj.items() if mj]
    return found + encoder_lines(scenario)


def _delay_lines(known: prediction.StabilityAnswer) -> list[str]:
    """Return the proof for any constant delay with its condition, or the reasons against it."""
    proof = known.at_any_delay
    if proof is None:
        return []
    if known.proved:
        where = "while all contacts touch" if proof.touching else "in contact and free"
        at = f"; the gain around the loop is at most {proof.gain:.6f}" if proof.gain else ""
        return [f"Stable at any constant delay, hands off, {where}{at}."]
    reasons: Sequence[str] = proof.reasons
    if proof.proved:
        reasons = ["the server port will limit its environment, or that is not known"]
        if known.limited is False:
            reasons = ["the nearest linear scenario is not stable"]
    return [f"Not proved stable at any constant delay: {'; '.join(reasons)}."]


def unknown_delay(user: User) -> str:
    """Return why the tuning rules do not know a user's round trip."""
    both = [(record, link) for link in (user.link_up, user.link_down) for record in active(link)]
    effects = dict.fromkeys(each.name for each, link in both if each.spread_s(link) is None)
    return f"the longest delay by {', '.join(effects) or 'the links'} is not known"


def rule_margins(user: User, scenario: Scenario) -> Mapping[str, float]:
    """Return by how much a user's parameters meet the rules of a controller [N s/m]."""
    loop = loop_of(user, scenario.server)
    return record_of(scenario.controller).check(user.baseline, loop)


def _rule_lines(scenario: Scenario) -> list[str]:
    """Return the margins of each user's parameters to the rule of a controller without waves."""
    found = []
    for user in scenario.users:
        for rule, margin in rule_margins(user, scenario).items():
            verdict = "met, margin" if margin >= 0.0 else "NOT met, deficit"
            words = f"{verdict} {abs(margin):.1f} N s/m"
            if math.isnan(margin):
                words = f"unknown: {unknown_delay(user)}"
            found.append(f"{user.name}: rule '{rule}' {words}.")
    return found


def _no_effect_lines(scenario: Scenario) -> list[str]:
    """Return a warning for settings of filter and hold, which the strict channel has not."""
    default = flattened("master", MasterParams())
    found = [
        (user.name, f"{name} = {value}")
        for user in scenario.users
        for name, value in flattened("master", user.master).items()
        if name.startswith(("master.filter.", "master.hold")) and value != default[name]
    ]
    if not found:
        return []
    users, settings = (", ".join(dict.fromkeys(each)) for each in zip(*found, strict=True))
    return [
        f"Warning: {users}: without effect: {settings}. channel = strict, the default, has "
        "neither anti-aliasing filter nor hold; channel = plain has both."
    ]


def _aliasing_lines(scenario: Scenario) -> list[str]:
    """Return a warning for every filter that lets aliasing through, with its users."""
    found: dict[str, list[str]] = {}
    for user in scenario.users:
        master, gain = user.master, prediction.aliasing_gain(user)
        tick_s, rate_drop = master.tick_s, master.rate_drop
        texts = aliasing.warnings_of(master.filter, tick_s=tick_s, rate_drop=rate_drop)
        if not texts and gain > prediction.ALIASING_BOUND:
            texts = [
                "the anti-aliasing filter is weak: in the worst case packets carry "
                f"{gain:.4g} times the energy that went in"
            ]
        for text in texts:
            found.setdefault(text, []).append(user.name)
    return [f"Warning: {', '.join(users)}: {text}." for text, users in found.items()]


def _stability_lines(scenario: Scenario, known: prediction.StabilityAnswer) -> list[str]:
    """Return stability by the exact model: of the scenario, or of the nearest linear one."""
    if known.exact is not None:
        return [f"{_stability(known.exact)}, hands off."]
    elements = ", ".join(dict.fromkeys(element.text for element in nonlinear(scenario)))
    if known.near is None:
        if elements:
            return [f"No exact model, not linear: {elements}. No linear scenario is near."]
        return [f"Stability of {known.unknown}."]
    near = f"Stability of the nearest linear scenario, {known.unknown}."
    if known.model is not None:
        settings = ", ".join(known.near.settings)
        near = f"The nearest linear scenario, with {settings}: {_stability(known.model)}."
    return [f"No exact model, not linear: {elements}.", near]


def _stability(model: Exact) -> str:
    word = "Stable" if model.stable else "NOT stable"
    return f"{word}: spectral radius {model.spectral_radius:.5g}"


def encoder_lines(scenario: Scenario) -> list[str]:
    """Return in words what the ports behind such encoders may give out; nothing without one."""
    found = []
    for user in scenario.users:
        if not behind_counts(user, scenario):
            continue
        words = f"{user.name}: {count_bound(user.master, user.device).text}"
        if not held(user):
            kind = user.operator.kind
            words += f" Without an arm on the device (operator.kind = {kind}) no bound is known."
        found.append(words)
    return found


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
