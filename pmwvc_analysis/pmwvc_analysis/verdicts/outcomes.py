# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Predictions beside what was measured: each a hit or a miss, with numbers and tolerance.

F tau/(2b) is the offset of a device from its avatar in a press at rest that the channel alone
decides: nothing is compared in a session that was not stable, where a limit has cut a force, or
where the offset still changes.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from pmwvc_analysis.budget.criterion import passive_by_account, together
from pmwvc_analysis.prediction.lag import RATIO_TOLERANCE, lag_s, transformer
from pmwvc_analysis.traces import thresholds as th
from pmwvc_analysis.traces.stages import Stage
from pmwvc_analysis.verdicts.stability import LIMITED
from pmwvc_core.network.effects import is_random
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.impedance import first_axis

UNKNOWN = "how late packets come, and which are lost, left out or skipped, is not known before"
OFFSET = "offset of the device from its avatar at the end"
HANDS = "hands damp, contacts can part, and a short session may end before it shows"


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

    Where parameters changed in flight (``steady`` has several stages), those of stability and
    offsets are of the parameters at the start and remain open.
    """
    found = [_stability(summary)]
    if len(steady) > 1:
        begins = f"Parameters changed, first at {steady[1].start_s:.2f} s"
        text = "the prediction is that of the parameters at the start, and open."
        found = [Outcome("stability", None, f"{begins}: {text}")]
    if all(passive_by_account(each) for each in [scenario, *(s.scenario for s in steady)]):
        found.append(_passivity(summary))
    if len(steady) <= 1 and summary["prediction"]["mass_felt"] is not None:
        found += offsets(scenario, summary)
    return found


def _passivity(summary: dict[str, Any]) -> Outcome:
    """Return what became of the prediction that every port is passive while its loop runs."""
    ports = summary["passivity"]["ports"]
    hit = together(None if port["held_j"] > 0.0 else port["passive"] for port in ports)
    unknown = "open, a port was not judged, or its loop stood still"
    was = {True: "they were", False: "they were NOT", None: unknown}
    return Outcome("passivity", hit, f"Predicted that all ports are passive: {was[hit]}.")


def _stability(summary: dict[str, Any]) -> Outcome:
    predicted, was = summary["prediction"]["stable"], summary["stable"]
    found = "stable" if was else "not stable"
    hit, text = None, f"No stability was predicted; the session was {found}."
    if was is None:
        text = "Stability was not judged: the prediction is open."
    elif predicted is not None and predicted == was:
        hit, text = True, f"Predicted {'stable' if was else 'unstable'}: it was."
    elif predicted is False:
        text = f"Predicted unstable, but it was stable: {HANDS}."
    elif predicted and summary["instability"] == LIMITED:
        text = "Predicted stable, without limits: these took over, so it is open."
    elif predicted:
        hit, text = False, "Predicted stable, but it was not (missed): see the events."
    return Outcome("stability", hit, text)


def offsets(scenario: Scenario, summary: dict[str, Any]) -> list[Outcome]:
    """Return what became of the predicted offset of every user who presses at the end."""
    users, found = {user.name: user for user in scenario.users}, list[Outcome]()
    for entry in (each for each in summary["users"] if each["name"] in users):
        user = users[entry["name"]]
        force, was_m = entry["force_final_n"], entry["drift_m"]  # lists: of several axes
        known = isinstance(force, float) and isinstance(was_m, float)
        same = abs(transformer(user) - 1.0) <= RATIO_TOLERANCE  # else device and avatar differ
        if not (known and same and abs(force) >= th.LEAST_FORCE_N):
            continue
        m_per_s = force / (2.0 * first_axis(user.in_contact.impedance))
        even_m = m_per_s * lag_s(user, scenario, live=summary["source"] == "live")
        tolerance_m = _tolerance_m(even_m)
        hit: bool | None = abs(was_m - even_m) <= tolerance_m
        ends = f"{'hit' if hit else 'missed'}; tolerance {tolerance_m * 1e3:.2f} mm"
        if reason := next(_open(user, scenario, summary, entry, even_m, hit is True), ""):
            hit, ends = None, f"open: {reason}"
        word = "expected" if hit is None else "predicted"
        amounts = f"{word} {even_m * 1e3:+.2f} mm, measured {was_m * 1e3:+.2f} mm"
        text = f"{user.name}: {OFFSET}: {amounts} ({ends})."
        numbers = () if hit is None else (even_m, was_m, tolerance_m, "m")
        found.append(Outcome("offset", hit, text, user.name, *numbers))
    return found


def _open(
    user: User,
    scenario: Scenario,
    summary: dict[str, Any],
    entry: dict[str, Any],
    even_m: float,
    hit: bool,
) -> Iterator[str]:
    """Yield in words why an offset is not that of a press at rest, or was not known before."""
    live, name = summary["source"] == "live", user.name
    random = live or is_random(user.link_up) or is_random(user.link_down)
    left_out = user.master.deadband.is_on or user.contact.deadband.is_on
    skipped = not scenario.strict and user.master.frame_s < scenario.server.period_s
    if random or left_out or skipped:
        yield UNKNOWN
    if summary["stable"] is False:
        yield "the session was not stable, so this is no press at rest"
    force, avatar = entry["force_final_n"], entry["avatar_force_final_n"]
    held, asked = f"the device was held with {force:.2f} N", entry["force_commanded_final_n"]
    known_n = isinstance(avatar, float)
    if known_n and abs(force - avatar) > th.SAME_FORCE * max(abs(force), abs(avatar)):
        yield f"{held}, its avatar with {avatar:.2f} N"
    if asked is not None and abs(asked - force) > th.LIMITED["N"] + th.LIMITED_RATIO * abs(asked):
        yield f"{held} by a limit, {asked:.2f} N were commanded"
    change_m, speed_m_s = entry["drift_change_m"], abs(entry["velocity_final_m_s"] or 0.0)
    if isinstance(change_m, float) and change_m > _tolerance_m(even_m):
        yield f"it still changed by {change_m * 1e3:.2f} mm in the last half second"
    if speed_m_s * lag_s(user, scenario, live=live) > 2.0 * _tolerance_m(even_m):
        yield f"the device still moved with {speed_m_s * 1e3:.0f} mm/s"
    own = f"{name} master", "limit"
    what = [e["what"].split()[0] for e in summary["events"] if (e["who"], e["kind"]) == own]
    if what and not (hit or scenario.strict):
        yield f"its {what[0]} was limited, which took motion out of the wave"


def _tolerance_m(predicted_m: float) -> float:
    return th.OFFSET_M + th.OFFSET_RATIO * abs(predicted_m)
