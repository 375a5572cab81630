# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The predicted offsets of devices from their avatars beside those measured at the end.

F tau/(2b) is the offset of a press at rest that the channel alone decides: nothing is compared in
a session that was not stable, where a limit has cut a force, or where the offset still changes.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from pmwvc_analysis.budget.result import SERVER
from pmwvc_analysis.prediction.lag import RATIO_TOLERANCE, lag_s, transformer
from pmwvc_analysis.traces.stages import Stage
from pmwvc_core.network.effects import is_random
from pmwvc_core.params import DeadbandParams
from pmwvc_core.scenario.scenario import Scenario, User
from pmwvc_core.wave.impedance import first_axis

LEAST_FORCE_N = 0.2  # below that, an offset is not that of a grip
UNEVEN = "The delay of a playout follows how late packets come, which is not known before."
TOO_LATE = (
    "channel = zeroing loses the motion of packets that do not come in time, which is not known "
    "before."
)
HELD = (
    "channel = plain holds a wave until the next packet: what late and lost ones make of the "
    "motion is not known before."
)
SKIPPED = (
    "channel = plain uses the newest packet of a server step only: what the others carried of the "
    "motion is lost, how much is not known before."
)
LATE = ("stall", "link", "damping")  # kinds of events behind which packets come late
SAME_FORCE = 0.1  # difference of the forces of device and avatar at rest, of the larger one
OFFSET = "offset of the device from its avatar at the end"
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
    until: float | None = None  # the other end, where a range is predicted


def offsets(scenario: Scenario, summary: dict[str, Any]) -> list[Outcome]:
    """Return what became of the predicted offset of every user who presses at the end."""
    entries = {entry["name"]: entry for entry in summary["users"]}
    found = []
    for user in scenario.users:
        entry = entries.get(user.name, {})
        force, drift = entry.get("force_final_n"), entry.get("drift_m")
        if isinstance(force, float) and isinstance(drift, float) and abs(force) >= LEAST_FORCE_N:
            found.append(_of_user(user, scenario, summary, entry))
    return found


def _of_user(
    user: User, scenario: Scenario, summary: dict[str, Any], entry: dict[str, Any]
) -> Outcome:
    """Return the outcome of an offset. On a live strict channel the lag follows late packets: up
    to F/(2b) times what they made it longer is added.
    """
    force, was_m, live = entry["force_final_n"], entry["drift_m"], summary["source"] == "live"
    if abs(transformer(user) - 1.0) > RATIO_TOLERANCE:
        scale = math.sqrt(transformer(user))
        text = (
            f"{user.name}: no offset of device and avatar is predicted: the ends have "
            f"different impedance, the device moves {scale:.3g} times as far."
        )
        return Outcome("offset", None, text, user.name)
    m_per_s, late_s = force / (2.0 * first_axis(user.impedance)), entry["late_s"]
    even_m = m_per_s * lag_s(user, scenario, live=live)
    reason = _decided_by_network(user, scenario, summary) or _unsteady(summary, entry, even_m)
    ranges = live and scenario.strict
    if not reason and ranges and late_s is None:
        reason = UNEVEN
    if reason:
        begins = " as it begins" if user.link_up.schedule or user.link_down.schedule else ""
        text = (
            f"{user.name}: {OFFSET}: measured {was_m * 1e3:+.2f} mm; {even_m * 1e3:+.2f} mm are "
            f"expected of the link{begins}. {reason}"
        )
        return Outcome("offset", None, text, user.name)
    until_m = even_m + m_per_s * late_s if ranges else None
    low_m, high_m = sorted((even_m, even_m if until_m is None else until_m))
    tolerance_m = _tolerance_m(even_m)
    hit = low_m - tolerance_m <= was_m <= high_m + tolerance_m
    text = (
        f"{user.name}: {OFFSET}: predicted {predicted_words(even_m, until_m)}, measured "
        f"{was_m * 1e3:+.2f} mm ({'hit' if hit else 'missed'}; "
        f"tolerance {tolerance_m * 1e3:.2f} mm)."
    )
    if ranges:
        text += f" Late packets made its lag up to {late_s * 1e3:.0f} ms longer."
    return Outcome("offset", hit, text, user.name, even_m, was_m, tolerance_m, "m", until_m)


def predicted_words(predicted_m: float, until_m: float | None) -> str:
    """Return a predicted offset, or the range of it, in words."""
    until = "" if until_m is None else f" to {until_m * 1e3:+.2f}"
    return f"{predicted_m * 1e3:+.2f}{until} mm"


def _decided_by_network(user: User, scenario: Scenario, summary: dict[str, Any]) -> str:
    """Return in words what of the way of a user's packets no one knows before; else empty."""
    live = summary["source"] == "live"
    if user.master.deadband.is_on or user.contact.deadband.is_on:
        return f"{_left_out(user.name, summary)}; the longest wait for one counts."
    if is_random(user.link_up) or is_random(user.link_down) or (live and scenario.zeroing):
        return UNEVEN if scenario.strict else TOO_LATE if scenario.zeroing else HELD
    if not scenario.strict and user.master.frame_s < scenario.server.period_s:
        return SKIPPED
    if live and not scenario.strict and (event := _held_up(user.name, summary)):
        return f"{event['who']}, at {event['time_s']:.2f} s: {event['what']}. {HELD}"
    return ""


def _held_up(name: str, summary: dict[str, Any]) -> dict[str, Any] | None:
    """Return the first event in which packets of a user came late, or a loop did not run."""
    own = (name, f"{name} master", f"link {name}/up", f"link {name}/down", SERVER, "netem")
    late = (each for each in summary["events"] if each["kind"] in LATE and each["who"] in own)
    return next((event for event in late if event["time_s"] is not None), None)


def _unsteady(summary: dict[str, Any], entry: dict[str, Any], even_m: float) -> str:
    """Return why an offset is not that of a press at rest, in words; empty where it is."""
    if summary["stable"] is False:
        return "The session was not stable, so this is no press at rest."
    force, avatar = entry["force_final_n"], entry["avatar_force_final_n"]
    known = isinstance(avatar, float)
    if known and abs(force - avatar) > SAME_FORCE * max(abs(force), abs(avatar)):
        return f"The device was held with {force:.2f} N, its avatar with {avatar:.2f} N."
    change_m = entry["drift_change_m"]
    if isinstance(change_m, float) and change_m > _tolerance_m(even_m):
        return f"It still changed by {change_m * 1e3:.2f} mm in the last half second."
    return ""


def _tolerance_m(predicted_m: float) -> float:
    return OFFSET_M + OFFSET_RATIO * abs(predicted_m)


def _left_out(name: str, summary: dict[str, Any]) -> str:
    """Return how many packets of a user the deadbands of both ends left out, in words."""
    saved = {entry["name"]: entry["left_out"] for entry in summary["receptions"]}
    ways = [
        f"{saved[link]:.0%} of the packets {way}"
        for way in ("up", "down")
        if saved.get(link := f"{name}/{way}") is not None
    ]
    return f"A deadband left out {' and '.join(ways) or 'packets'}"


def same_lag(steady: Sequence[Stage]) -> bool:
    """Tell whether impedances, links and coupling are those of the start in all stages."""

    def decides(scenario: Scenario) -> list[Any]:
        links = [id(link) for user in scenario.users for link in (user.link_up, user.link_down)]
        ends = [
            (replace(user.master, rate_drop=1, deadband=DeadbandParams()), user.server_impedance)
            for user in scenario.users
        ]
        return [scenario.server.coupling, scenario.server.integrator, links, ends]

    return all(decides(each.scenario) == decides(steady[0].scenario) for each in steady[1:])
