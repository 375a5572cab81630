# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict of a session in lines, and the reasons for the exit code of ``--check``.

Everything is read from the summary: terminal, report and exit code cannot differ.
"""

from typing import Any

from pmwvc_analysis.budget.criterion import together
from pmwvc_analysis.traces.felt import BLOW_N
from pmwvc_core.words import count

BREAK_S = 0.1  # without force or coupling: as long as a grip takes to react to a load
LEAST_COUPLED = 0.5  # of the time, or the session shows little of the coupling
TAKEN = ("damping", "release", "limit")  # kinds of events in which safety limits took over

Line = dict[str, Any]  # ``ok``: true, false, or null for what is not known; ``text``


def state_text(stable: bool | None, instability: str | None) -> str:
    """Return a verdict on stability in a few words."""
    if stable is None:
        return "stability not judged"
    return "stable" if stable else f"not stable: {instability}"


def verdict_lines(summary: dict[str, Any]) -> list[Line]:
    """Return the verdict, the most important first."""
    found = [_stability(summary)]
    found += [_line(False, f"Interrupted: {text}.") for text in summary["interrupted"]]
    for owner, text in summary["passivity"]["text"].items():
        ok = together(port["passive"] for port in _ports(summary, owner))
        found.append(_line(ok, f"{owner}: {text}."))
    if not summary["passivity"]["ports"]:
        found.append(_line(None, "Passivity not judged: no user was recorded."))
    found += [_line(False, f"Another publisher: {text}.") for text in summary["strangers"]]
    found += [_line(False, f"{who}: {text}.") for who, text in disturbances(summary).items()]
    found += [*interventions(summary), *kept_apart(summary), *_clocks(summary)]
    found += [_line(False, each["text"]) for each in summary["outcomes"] if each["hit"] is False]
    return found + _recording(summary)


def reasons(summary: dict[str, Any]) -> list[str]:
    """Return why a session does not pass ``--check``; empty when it does."""
    found = []
    if summary["stable"] is False:
        found.append(f"not stable: {summary['instability']}")
    elif summary["stable"] is None:
        found.append(summary["stability"]["text"])
    for owner, text in summary["passivity"]["text"].items():
        if any(p["passive"] is False or p["not_judged"] for p in _ports(summary, owner)):
            found.append(f"{owner}: {text}")
    found += summary["interrupted"]
    found += [f"another publisher: {text}" for text in summary["strangers"]]
    found += [f"{who}: {text}" for who, text in disturbances(summary).items()]
    if summary["recording"]["holes"]:
        found.append(hole_text(summary))
    elif missing := sum(summary["recording"]["missing"].values()):
        found.append(f"{count(missing, 'message')} not recorded")
    return found


def _line(ok: bool | None, text: str) -> Line:
    return {"ok": ok, "text": text}


def _ports(summary: dict[str, Any], owner: str) -> list[dict[str, Any]]:
    return [port for port in summary["passivity"]["ports"] if port["owner"] == owner]


def _stability(summary: dict[str, Any]) -> Line:
    until_s, stable = summary["judged_until_s"], summary["stable"]
    until = f" until {until_s:.2f} s" if until_s < summary["duration_s"] else ""
    begins = f"Stable{until}" if stable else f"Not stable{until}, {summary['instability']}"
    begins = "Stability not judged" if stable is None else begins
    return _line(stable, f"{begins}: {summary['stability']['text']}.")


def disturbances(summary: dict[str, Any]) -> dict[str, str]:
    """Return whom blows, a missing force or no coupling disturbed, unasked for by the scenario."""
    found = {}
    for user in summary["users"]:
        parts = []
        if user["coupled_ratio"] < LEAST_COUPLED:
            ratio = user["coupled_ratio"]
            parts.append(f"coupled for {ratio:.0%} of the time" if ratio else "never coupled")
        elif (user["disturbed_s"] or 0.0) > BREAK_S:
            held_n = user["force_undisturbed_n"]
            half = f", or with less than half of its {held_n:.2f} N" if held_n else ""
            parts.append(f"not coupled{half and half + ','} for {user['disturbed_s']:.2f} s")
        if user["blows"]:
            step_n, at_s = user["force_step_max_n"], user["force_step_max_s"]
            more = f" and {user['blows'] - 1} more above {BLOW_N:g} N" if user["blows"] > 1 else ""
            parts.append(f"the force changed by {step_n:.2f} N within 1 ms at {at_s:.2f} s{more}")
        if parts:
            found[user["name"]] = "; ".join(parts)
    return found


def interventions(summary: dict[str, Any]) -> list[Line]:
    """Return that safety limits took over, with when and why: never a tick."""
    found = []
    events = [event for event in summary["events"] if event["kind"] in TAKEN]
    for name in (user["name"] for user in summary["users"]):
        own = [event for event in events if event["who"] == f"{name} master"]
        texts = [f"at {event['time_s']:.2f} s: {event['what']}" for event in own]
        if len(texts) > 1:
            texts[1:] = [f"; {count(len(texts) - 1, 'more event')}, the last {texts[-1]}"]
        found += [_line(None, f"{name}, {''.join(texts)}.")] if texts else []
    return found


def kept_apart(summary: dict[str, Any]) -> list[Line]:
    """Return whose avatar is apart from its device since joining, how far and why."""
    found = [(user["name"], user["kept_apart"]) for user in summary["users"]]
    return [_line(None, f"{name}, at the end: {text}.") for name, text in found if text]


def _clocks(summary: dict[str, Any]) -> list[Line]:
    """Return how the clocks of several hosts were aligned; nothing where there is one clock."""
    found = []
    for name, clock in summary["alignment"].items():
        if clock["how"] == "echo":
            within = f"{clock['uncertainty_s'] * 1e3:.2f} ms (drift {clock['drift_ppm']:+.1f} ppm)"
            text = "clock aligned with the server's by the echoes of packets, within"
            found.append(_line(True, f"{name}: {text} {within}."))
        elif clock["how"] == "wall clock" and summary["source"] == "live":
            text = "clock offset not known, no echoes; aligned by wall time."
            found.append(_line(None, f"{name}: {text}"))
    return found


def _recording(summary: dict[str, Any]) -> list[Line]:
    recording = summary["recording"]
    if recording["holes"]:
        return [_line(False, f"{hole_text(summary).capitalize()}; nothing is judged there.")]
    if missing := sum(recording["missing"].values()):
        what = "numbered messages were not recorded; see the last table."
        return [_line(False, f"{missing} {what}")]
    whole = _line(True, "Nothing is missing in the recording.")
    return [whole] if recording["messages"] else []


def hole_text(summary: dict[str, Any]) -> str:
    """Return how long, and from when to when, something was not recorded."""
    found = summary["recording"]["not_recorded_s"]
    total = sum(end - start for start, end in found)
    shown = ", ".join(f"{start:.2f} to {end:.2f} s" for start, end in found[:3])
    more = f" and {len(found) - 3} more intervals" if len(found) > 3 else ""
    return f"not recorded for {total:.2f} s: {shown}{more}"
