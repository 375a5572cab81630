# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Predictions beside what was measured: each a hit or a miss, with numbers and tolerance.

Offsets of devices from their avatars: :mod:`.offsets`.
"""

from collections.abc import Sequence
from typing import Any

from pmwvc_analysis.budget.criterion import bounded, together
from pmwvc_analysis.traces.stages import Stage, text_of
from pmwvc_analysis.verdicts.offsets import Outcome, offsets, same_lag
from pmwvc_analysis.verdicts.stability import LIMITED
from pmwvc_core.master.count_bound import CountBound
from pmwvc_core.plural import listed
from pmwvc_core.quantities import quantity
from pmwvc_core.scenario.scenario import Scenario


def outcomes(
    scenario: Scenario, summary: dict[str, Any], steady: Sequence[Stage] = ()
) -> list[Outcome]:
    """Return what became of every prediction of a summary.

    Where parameters changed in flight (``steady`` has several stages), the prediction is that of
    the parameters at the start and remains open; offsets are predicted from those at the end,
    where no impedance, link or coupling changed.
    """
    if len(steady) > 1:
        text = "the prediction is that of the parameters at the start, and open."
        text = f"Parameters changed ({text_of(steady)}): {text}"
        found = [Outcome("stability", None, text)]
        if not same_lag(steady):
            return found
        scenario = steady[-1].scenario
    else:
        found = [_stability(summary)]
    if passive_by_account(scenario):
        found.append(_passivity(summary))
    for user in scenario.users:
        if bound := bounded(user, scenario):
            found.append(_counts(user.name, bound, summary))
    if summary["prediction"]["mass_felt"] is not None:
        found += offsets(scenario, summary)
    return found


def passive_by_account(scenario: Scenario) -> bool:
    """Tell whether every port is passive by the strict channel's accounts, whatever the network
    does: the motion is exactly what the device reports, and no part gives out energy by its law.
    """
    exact = all(
        user.device.is_simulated
        and user.device.encoder_step_m <= 0.0
        and not user.master.bank.as_published
        for user in scenario.users
    )
    return exact and scenario.strict and scenario.coupling.passive(scenario.server)


def _passivity(summary: dict[str, Any]) -> Outcome:
    ports = summary["passivity"]["ports"]
    hit = together(port["passive"] for port in ports)
    violated = [port for port in ports if port["passive"] is False]
    if violated and all(port["held_j"] for port in violated):
        who = listed(sorted({port["owner"] for port in violated}))
        text = "Predicted that all ports are passive while loops run: open, the loop of"
        text = f"{text} {who} stood still, and its last force stayed on."
        return Outcome("passivity", None, text)
    left = sorted({port["owner"] for port in ports if port["passive"] is None})
    was = {
        True: "they were",
        False: "they were NOT",
        None: f"not all were judged ({listed(left) or 'no port was recorded'})",
    }[hit]
    return Outcome("passivity", hit, f"Predicted that all ports are passive: {was}.")


def _counts(name: str, bound: CountBound, summary: dict[str, Any]) -> Outcome:
    """Compare what the port of a hand behind counts gave out with its bound."""
    ports = summary["passivity"]["ports"]
    port = next((p for p in ports if (p["owner"], p["part"]) == (name, "hand_port")), None)
    text = (
        f"Behind counts of {1e6 * bound.step_m:.3g} um the port of the hand was predicted to give "
        f"out at most {quantity(bound.given_j, 'J')} more than it took in"
    )
    given_j = None
    if port is not None and port["least_balance_j"] is not None and port["passive"] is not None:
        given_j = max(0.0, -port["least_balance_j"] - port["declared_j"])
    if given_j is None:
        return Outcome("encoder", None, f"{text}: that was not judged.", name, bound.given_j)
    hit = given_j <= bound.given_j
    text = f"{text}: it gave {quantity(given_j, 'J')}."
    return Outcome("encoder", hit, text, name, bound.given_j, given_j, 0.0, "J")


def _stability(summary: dict[str, Any]) -> Outcome:
    predicted, was = summary["prediction"]["stable"], summary["stable"]
    if was is not None and predicted is None and summary["prediction"]["environment_limited"]:
        limited = any(user["environment_limited"] for user in summary["users"])
        text = "it did." if limited else "it did not have to."
        text = f"Predicted that the server port limits the environment: {text}"
        return Outcome("environment", True if limited else None, text)
    hit: bool | None = None
    if was is None:
        text = "Stability was not judged: the prediction is open."
    elif predicted is None:
        text = f"No stability was predicted; the session was {'stable' if was else 'not stable'}."
    elif predicted == was:
        hit, text = True, f"Predicted {'stable' if was else 'unstable'}: it was."
    elif was:
        text = (
            "Predicted unstable, but it was stable: hands damp, contacts can part, and a short "
            "session may end before it shows."
        )
    elif summary["instability"] == LIMITED:
        text = (
            "Predicted stable, without limits of force and speed: these took over, so the "
            "prediction is open."
        )
    else:
        hit, text = False, "Predicted stable, but it was not (missed): see the events."
    return Outcome("stability", hit, text)
