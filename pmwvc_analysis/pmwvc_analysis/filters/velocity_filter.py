# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The margins over frequency, the noise and the failed conditions of a velocity filter (App. D).

Conditions: :mod:`pmwvc_core.wave.aliasing`; which filter: ``velocity_filter_design`` beside it.
The equivalent form is judged by what it is at the device, too. With the low-pass branch behind it,
F/(b xd) = (1 - R H_LP)/(1 + R H_LP) - 2 s H_HP, whose real part is least for the R that makes
R H_LP = |H_LP|:

    (1 - |H_LP|)/(1 + |H_LP|) - 2 s Re H_HP >= 0    at all frequencies.

A pair that keeps energy (complementary) adds nothing to what anti-aliasing filter and rate drop do
by themselves: its switching gain is the larger of s and their g.

Equations: docs/theory.md 7.7.
"""

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.controllers.library import proofs_hold
from pmwvc_core.errors import PmwvcError
from pmwvc_core.numeric import Array
from pmwvc_core.params import MasterParams, VelocityFilterParams
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.wave import velocity_filter_design as filters
from pmwvc_core.wave.aliasing import TOLERANCE, margins, switching_gain, worst_case_gain

POINTS = 4001
FOLDED_POINTS = 129  # frequencies at which the images of a rate drop are looked at
LOWEST = 1e-4  # of half the tick rate
CONDITIONS = {  # passivity ... by the numbers of an answer
    "in_phase": "with an environment in phase (Eq. 14), margin {in_phase_margin:+.4f}, least at "
    "{in_phase_worst_hz:.3g} Hz",
    "any_environment": "with any environment, margin {any_environment_margin:+.4f}, least at "
    "{any_environment_worst_hz:.3g} Hz",
    "switching": "with a switching environment behind the rate drop, worst-case gain "
    "{switching_gain:.4f}, must not exceed 1",
    "port": "at the device (equivalent form), {port_margin:+.4f} b of damping",
}


class VelocityFilter(NamedTuple):
    """A filter with its margins; arrays over ``margins["frequency_hz"]``."""

    master: MasterParams  # with alpha or cutoff_hz completed
    designed: str  # given, or by which rule
    margins: dict[str, Any]
    port: Array  # Re F/(b xd) at worst, of the equivalent form
    gain: Array  # |F_m/(b xd)| while nothing comes back
    switching_gain: float
    noise_gain: float


def judge(scenario: Scenario) -> VelocityFilter:
    """Return the velocity filter of the first user and its margins; of a user without one, that of
    the exact form with the same numbers; PmwvcError if the scenario has no waves, or no such
    filter exists.
    """
    if not proofs_hold(scenario.controller):
        raise PmwvcError(
            f"controller = {scenario.controller}: has no velocity filter; must be pmwvc"
        )
    master = scenario.users[0].master
    if not master.velocity_filter.is_on:
        own = dataclasses.replace(master.velocity_filter, kind="exact")
        master = dataclasses.replace(master, velocity_filter=own)
    whole = filters.chosen(master)
    half_hz = 0.5 / whole.tick_s
    points = np.geomspace(LOWEST * half_hz, half_hz, POINTS)
    frequency_hz = np.sort(np.append(points, whole.velocity_filter.cutoff_hz or 1.0))
    low, high = filters.branches(whole, frequency_hz)
    share, size = whole.velocity_filter.share, np.abs(low)
    return VelocityFilter(
        master=whole,
        designed=_rule(master.velocity_filter),
        margins=margins(low, high, frequency_hz, share=share),
        port=(1.0 - size) / (1.0 + size) - 2.0 * share * high.real,
        gain=np.abs(filters.velocity_gain(whole, frequency_hz)),
        switching_gain=_switching(whole),
        noise_gain=filters.noise_gain(whole),
    )


def _rule(own: VelocityFilterParams) -> str:
    if own.alpha is not None or own.cutoff_hz is not None:
        return "given"
    if own.splits:
        return "half the packet rate"
    return "flattest in phase" if own.order == 1 else "lowest cut-off for any environment"


def _switching(master: MasterParams) -> float:
    own, tick_s, ratio = master.velocity_filter, master.tick_s, master.rate_drop
    if own.splits:
        squared = float(worst_case_gain(master.filter, tick_s=tick_s, rate_drop=ratio))
        return max(float(own.share), float(np.sqrt(squared)))
    turn = np.linspace(0.0, 0.5 / ratio, FOLDED_POINTS)
    low, high = filters.branches(master, np.add.outer(turn, np.arange(ratio) / ratio) / tick_s)
    return switching_gain(np.abs(low), own.share * np.abs(high))


def answer(scenario: Scenario, found: VelocityFilter) -> dict[str, Any]:
    """Return the document of ``--json``; ``port_margin`` [of b] is that of the equivalent form."""
    own = found.master.velocity_filter
    port_margin = float(found.port.min()) if own.in_force else None
    left = {  # by how much each of ``CONDITIONS`` is met; None where it does not apply
        "in_phase": found.margins["in_phase_margin"],
        "any_environment": found.margins["any_environment_margin"],
        "switching": 1.0 - found.switching_gain,
        "port": port_margin,
    }
    ends = "margin", "worst_hz"
    return {
        "scenario": scenario.name,
        "user": scenario.users[0].name,
        "kind": own.kind,
        "order": own.order,
        "share": float(own.share),
        "alpha": own.alpha,
        "cutoff_hz": own.cutoff_hz,
        "designed": found.designed,
        **{name: value for name, value in found.margins.items() if name.endswith(ends)},
        "switching_gain": found.switching_gain,
        "port_margin": port_margin,
        "noise_gain": found.noise_gain,
        "flags": [name for name, by in left.items() if by is not None and by < -TOLERANCE],
    }


def sentences(result: dict[str, Any]) -> list[str]:
    """Return an answer for a terminal."""
    where = (
        f"(z - 1)/(z - {result['alpha']:.5f})"
        if result["alpha"] is not None
        else f"Butterworth of order {result['order']} at {result['cutoff_hz']:.4g} Hz"
    )
    lines = [
        f"{result['scenario']}, {result['user']}: {result['kind']} velocity filter, {where}, "
        f"feedback share {result['share']:g} ({result['designed']})",
        f"  encoder noise in the force: {result['noise_gain']:.3g} of that without the filter "
        f"(power lower by a factor of {1.0 / max(result['noise_gain'], 1e-9) ** 2:.0f})",
    ]
    signless = {  # zero, rounded
        name: round(value, 4) + 0.0
        for name, value in result.items()
        if name.endswith("margin") and value is not None
    }
    for name, words in CONDITIONS.items():
        if name != "port" or "port_margin" in signless:
            verdict = "not met" if name in result["flags"] else "met"
            lines.append(f"  {verdict}: passivity {words.format_map(result | signless)}")
    return lines
