# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict of a session in lines. Terminal, report and exit code of ``--check`` have these.

Everything is read from the summary. A line is good, bad or neither; it ``fails`` where a session
with it does not pass ``--check``.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from pmwvc_analysis.budget.criterion import together
from pmwvc_analysis.traces.thresholds import BLOW_N, BREAK_S, LEAST_COUPLED, SKIPPED
from pmwvc_core.words import count

TAKEN = ("damping", "release", "limit")  # kinds of events in which safety limits took over
LOST = ("slip", "drop")  # in which a grip did not hold


class Line(NamedTuple):
    """One statement; ``ok`` is None for what is not known, or is no fault."""

    ok: bool | None
    text: str
    fails: bool = False


def state_text(stable: bool | None, instability: str | None, until: str = "") -> str:
    """Return a verdict on stability in a few words."""
    if stable is None:
        return "stability not judged"
    return f"stable{until}" if stable else f"not stable{until}, {instability}"


def lines(summary: dict[str, Any]) -> Iterator[Line]:
    """Yield the verdict, the most important first."""
    yield _stability(summary)
    for text in summary["interrupted"]:
        yield Line(False, f"Interrupted: {text}.", fails=True)
    for owner, text in summary["passivity"]["text"].items():
        ports = [port for port in summary["passivity"]["ports"] if port["owner"] == owner]
        fails = any(port["passive"] is False or port["not_judged"] for port in ports)
        yield Line(together(port["passive"] for port in ports), f"{owner}: {text}.", fails)
    if not summary["passivity"]["ports"]:
        yield Line(None, "Passivity not judged: no user was recorded.")
    for text in summary["strangers"]:
        yield Line(False, f"Another publisher: {text}.", fails=True)
    for user in summary["users"]:
        if text := _disturbed(user):
            yield Line(False, f"{user['name']}: {text}.", fails=True)
    for user in summary["users"]:
        name, events = user["name"], summary["events"]
        skipped, due = user["ticks_skipped"], user["ticks"] + user["ticks_skipped"]
        if skipped > SKIPPED * due:
            busy = "as on a machine that is busy or too slow ('pmwvc doctor' examines it)"
            took = f"; a tick took {us:.0f} µs" if (us := user["compute_us"]["p50"]) else ""
            yield Line(False, f"{name}: {skipped} of {due} ticks did not run, {busy}{took}.")
        yield from _reported(name, [e for e in events if e["who"] == f"{name} master"], TAKEN)
        kinds = {e["kind"] for e in events if e["who"] == name}
        if "join" in kinds and not kinds & {"grip", "contact"}:
            yield Line(None, f"{name} touched nothing.")
        if user["kept_apart"]:
            yield Line(None, f"{name}, at the end: {user['kept_apart']}.")
    for body in dict.fromkeys(e["who"] for e in summary["events"] if e["kind"] in LOST):
        yield from _reported(body, [e for e in summary["events"] if e["who"] == body], LOST)
    for name, clock in summary["alignment"].items():
        if clock["how"] == "wall clock" and summary["source"] == "live":
            yield Line(None, f"{name}: clock offset not known, no echoes; aligned by wall time.")
    for outcome in summary["outcomes"]:
        if outcome["hit"] is False:
            yield Line(False, outcome["text"])
    yield from _recording(summary["recording"])


def _stability(summary: dict[str, Any]) -> Line:
    until_s, stable = summary["judged_until_s"], summary["stable"]
    until = f" until {until_s:.2f} s" if until_s < summary["duration_s"] else ""
    begins = state_text(stable, summary["instability"], until).capitalize()
    return Line(stable, f"{begins}: {summary['stability']['text']}.", fails=stable is not True)


def _disturbed(user: dict[str, Any]) -> str:
    """Return how blows, a missing force or no coupling disturbed a user, unasked for by the
    scenario.
    """
    parts, ratio = [], user["coupled_ratio"]
    if ratio < LEAST_COUPLED:
        parts.append(f"coupled for {ratio:.0%} of the time" if ratio else "never coupled")
    elif (user["disturbed_s"] or 0.0) > BREAK_S:
        held_n = user["force_undisturbed_n"]
        half = f", or with less than half of its {held_n:.2f} N" if held_n else ""
        parts.append(f"not coupled{half and half + ','} for {user['disturbed_s']:.2f} s")
    if user["blows"]:
        step_n, at_s = user["force_step_max_n"], user["force_step_max_s"]
        more = f" and {user['blows'] - 1} more above {BLOW_N:g} N" if user["blows"] > 1 else ""
        parts.append(f"the force changed by {step_n:.2f} N within 1 ms at {at_s:.2f} s{more}")
    return "; ".join(parts)


def _reported(name: str, events: list[dict[str, Any]], kinds: Sequence[str]) -> Iterator[Line]:
    """Yield what happened, with when and why: the first event of some kinds, and the last."""
    texts = [f"at {e['time_s']:.2f} s: {e['what']}" for e in events if e["kind"] in kinds]
    if len(texts) > 1:
        texts[1:] = [f"; {count(len(texts) - 1, 'more event')}, the last {texts[-1]}"]
    if texts:
        yield Line(None, f"{name}, {''.join(texts)}.")


def _recording(recording: dict[str, Any]) -> Iterator[Line]:
    """Yield how long, and from when to when, something was not recorded."""
    if found := recording["holes"]:
        times = [f"{h['owner']} from {h['start_s']:.2f} to {h['end_s']:.2f} s" for h in found]
        times[3:] = [f"{len(found) - 3} more intervals"] if len(found) > 3 else []
        text = f"Not recorded: {', '.join(times)}; nothing is judged there."
        yield Line(False, text, fails=True)
    elif missing := sum(recording["missing"].values()):
        text = f"{count(missing, 'numbered message')} not recorded; see the last table."
        yield Line(False, text, fails=True)
    elif recording["messages"]:
        yield Line(True, "Nothing is missing in the recording.")
