# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Predictions beside what was measured: each a hit or a miss, with numbers and tolerance."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from pmwvc_analysis.prediction.environment import late_steps_s
from pmwvc_analysis.prediction.lag import RATIO_TOLERANCE, lag_s, transformer
from pmwvc_analysis.traces.stages import Stage, text_of
from pmwvc_core.network.effects import is_random
from pmwvc_core.params import DeadbandParams, MasterParams
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.impedance import first_axis

LEAST_FORCE_N = 0.2  # below that, an offset is not that of a grip
UNEVEN = "A playout is as late as the latest packet that it met, which is not known before."
TOO_LATE = (
    "channel = zeroing loses the motion of packets that do not come in time, which is not known "
    "before."
)
OFFSET_M = 0.3e-3  # tolerance of an offset, and
OFFSET_RATIO = 0.15  # that of its prediction


class Outcome(NamedTuple):
    """One prediction; numbers are null where the prediction is none of a number."""

    what: str
    hit: bool | None  # None: nothing was predicted, or the outcome is unknown
    text: str
    owner: str = ""
    predicted: float | None = None
    measured: float | None = None
    tolerance: float | None = None
    unit: str = ""


def outcomes(
    scenario: Scenario, summary: dict[str, Any], steady: Sequence[Stage] = ()
) -> list[Outcome]:
    """Return what became of every prediction of a summary.

    Where parameters changed in flight (``steady`` has several stages), the prediction is that of
    the parameters at the start and remains open; offsets are predicted from those at the end,
    where no impedance, link or coupling changed.
    """
    if len(steady) > 1:
        text = (
            f"Parameters changed ({text_of(steady)}): the prediction is that of the parameters at "
            "the start, and open."
        )
        found = [Outcome("stability", None, text)]
        if not _same_lag(steady):
            return found
        scenario = steady[-1].scenario
    else:
        found = [_stability(summary)]
    if passive_by_account(scenario):
        found.append(_passivity(summary))
    if summary["prediction"]["mass_felt"] is None:
        return found
    live = summary["source"] == "live"
    entries = {entry["name"]: entry for entry in summary["users"]}
    late = (
        "After a change of rates a playout may keep a longer margin than the new ones need."
        if len(steady) > 1 and not _same_rates(steady)
        else ""
    )
    for user in scenario.users:
        entry = entries.get(user.name, {})
        force, drift = entry.get("force_final_n"), entry.get("drift_m")
        if not isinstance(force, float) or not isinstance(drift, float):
            continue
        if abs(force) < LEAST_FORCE_N:
            continue
        if abs(transformer(user) - 1.0) > RATIO_TOLERANCE:
            scale = math.sqrt(transformer(user))
            text = (
                f"{user.name}: no offset of device and avatar is predicted: the ends have "
                f"different impedance, the device moves {scale:.3g} times as far."
            )
            found.append(Outcome("offset", None, text, user.name))
            continue
        per_lag = force / (2.0 * first_axis(user.impedance))
        lag = lag_s(user, scenario, live=live)
        spread = late_steps_s(user, scenario)
        drawn = is_random(user.link_up) or is_random(user.link_down)
        if user.master.deadband.is_on or user.contact.deadband.is_on:
            reason = f"{_left_out(user.name, summary)}; the longest wait for one counts."
            found.append(_offset_open(user, per_lag * lag, drift, reason))
        elif live and scenario.strict and not drawn:
            found.append(_offset_at_least(user, per_lag * lag, drift))
        elif (live or drawn) and (scenario.strict or scenario.zeroing):
            reason = UNEVEN if scenario.strict else TOO_LATE
            found.append(_offset_open(user, per_lag * lag, drift, reason))
        elif late:
            found.append(_offset_open(user, per_lag * lag, drift, late))
        else:
            found.append(_offset(user.name, per_lag * lag, per_lag * spread, drift))
    return found


def passive_by_account(scenario: Scenario) -> bool:
    """Tell whether every port is passive by the accounts of the strict channel, whatever the
    network does: where the motion is exactly what the device reports, and no part gives out energy
    by its law.
    """
    return (
        scenario.strict
        and scenario.coupling.passive(scenario.server)
        and all(
            user.device.plugin == "simulated"
            and not np.any(np.asarray(user.device.encoder_step_m) > 0.0)
            and user.master.bank.kind != "dissertation"
            for user in scenario.users
        )
    )


def _passivity(summary: dict[str, Any]) -> Outcome:
    judged = [port["passive"] for port in summary["passivity"]["ports"]]
    hit = False if False in judged else None if None in judged or not judged else True
    was = {True: "they were", False: "they were NOT", None: "not all were judged"}[hit]
    return Outcome("passivity", hit, f"Predicted that all ports are passive: {was}.")


def _offset_at_least(user: User, even_m: float, drift_m: float) -> Outcome:
    """Return the outcome of an offset that lateness can only make larger [m]."""
    tolerance = OFFSET_M + OFFSET_RATIO * abs(even_m)
    sign = math.copysign(1.0, even_m)
    hit = sign * drift_m >= abs(even_m) - tolerance
    text = (
        f"{user.name}: offset of the device from its avatar at the end: predicted at least "
        f"{even_m * 1e3:+.2f} mm, measured {drift_m * 1e3:+.2f} mm "
        f"({'hit' if hit else 'missed'}; tolerance {tolerance * 1e3:.2f} mm). How much larger it "
        f"gets is not predicted: {UNEVEN[0].lower()}{UNEVEN[1:]}"
    )
    return Outcome("offset", hit, text, user.name, even_m, drift_m, tolerance, "m")


def _left_out(name: str, summary: dict[str, Any]) -> str:
    """Return how many packets of a user the deadbands of both ends left out, in words."""
    saved = {entry["name"]: entry["left_out"] for entry in summary["receptions"]}
    ways = [
        f"{saved[link]:.0%} of the packets {way}"
        for way in ("up", "down")
        if saved.get(link := f"{name}/{way}") is not None
    ]
    return f"A deadband left out {' and '.join(ways) or 'packets'}"


def _offset_open(user: User, even_m: float, drift_m: float, reason: str) -> Outcome:
    """Say what was measured where something decides that is not known before."""
    begins = " as it begins" if user.link_up.schedule or user.link_down.schedule else ""
    text = (
        f"{user.name}: offset of the device from its avatar at the end: measured "
        f"{drift_m * 1e3:+.2f} mm; {even_m * 1e3:+.2f} mm are expected of the link{begins}. "
        f"{reason}"
    )
    return Outcome("offset", None, text, user.name)


def _same_lag(steady: Sequence[Stage]) -> bool:
    """Tell whether impedances, links and coupling are those of the start in all stages, rates and
    deadbands left aside.
    """
    first = steady[0].scenario.server
    servers = [stage.scenario.server for stage in steady]
    if any((s.coupling, s.integrator) != (first.coupling, first.integrator) for s in servers):
        return False
    return all(
        _but_rates(one.master) == _but_rates(two.master)
        and one.link_up is two.link_up
        and one.link_down is two.link_down
        and one.server_impedance == two.server_impedance
        for stage in steady[1:]
        for one, two in zip(steady[0].scenario.users, stage.scenario.users, strict=True)
    )


def _but_rates(master: MasterParams) -> MasterParams:
    return replace(master, rate_drop=1, deadband=DeadbandParams())


def _same_rates(steady: Sequence[Stage]) -> bool:
    """Tell whether packets and steps came as often in all stages."""
    rates = [
        (each.server.period_s, *(user.master.rate_drop for user in each.users))
        for each in (stage.scenario for stage in steady)
    ]
    return all(rate == rates[0] for rate in rates)


def _stability(summary: dict[str, Any]) -> Outcome:
    predicted, was = summary["prediction"]["stable"], summary["stable"]
    if was is None:
        return Outcome("stability", None, "Stability was not judged: the prediction is open.")
    if predicted is None and summary["prediction"]["environment_limited"] is True:
        limited = any(user["environment_limited"] for user in summary["users"])
        text = "it did." if limited else "it did not have to."
        text = f"Predicted that the server port limits the environment: {text}"
        return Outcome("environment", True if limited else None, text)
    if predicted is None:
        state = "stable" if was else "not stable"
        return Outcome("stability", None, f"No stability was predicted; the session was {state}.")
    if predicted and was:
        return Outcome("stability", True, "Predicted stable: it was.")
    if predicted:
        text = "Predicted stable, but it was not (missed): see the events."
        return Outcome("stability", False, text)
    if was:
        text = (
            "Predicted unstable, but it was stable: hands damp, contacts can part, and a short "
            "session may end before it shows."
        )
        return Outcome("stability", None, text)
    return Outcome("stability", True, "Predicted unstable: it was.")


def _offset(name: str, edge: float, width: float, was: float) -> Outcome:
    """Return the outcome of an offset, of which two bounds are predicted where it has a width
    [m].
    """
    low, high = sorted((edge, edge + width), key=abs)
    tolerance = OFFSET_M + OFFSET_RATIO * abs(high)
    hit = min(low, high) - tolerance <= was <= max(low, high) + tolerance
    until = f" to {high * 1e3:+.2f} mm, by how late the slope was learned;" if width else " mm,"
    text = (
        f"{name}: offset of the device from its avatar at the end: predicted "
        f"{low * 1e3:+.2f}{until} measured {was * 1e3:+.2f} mm "
        f"({'hit' if hit else 'missed'}; tolerance {tolerance * 1e3:.2f} mm)."
    )
    return Outcome("offset", hit, text, name, None if width else edge, was, tolerance, "m")
