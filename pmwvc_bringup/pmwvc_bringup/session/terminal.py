# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The terminal of a session: the prediction before it, a few numbers per user while it runs, and
the verdict after it.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import doing
from pmwvc_bringup.session import surroundings
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.words import count

STATES = ("starting", "coupled", "damping", "FAULT")


def user_words(
    name: str,
    ticks_hz: float | None,
    packets_hz: float | None,
    delays_s: Sequence[float] | None,
    force_n: float | None,
    state: int | None,
    contact: bool,
) -> str:
    """Return the newest values of one user, None where none came within the last second; delays
    are up, as the server sees it, and down: the division is a bound between two clocks.
    """
    word = "no data" if state is None else STATES[state]
    cells = [
        "-" if ticks_hz is None else f"{ticks_hz:.0f} Hz",
        "-" if packets_hz is None else f"{packets_hz:.0f}/s",
        "-" if delays_s is None else f"{'/'.join(f'{1e3 * each:.1f}' for each in delays_s)} ms",
        "-" if force_n is None else f"{force_n:+.2f} N",
        f"{word}, contact" if contact else word,
    ]
    return " ".join([name, *cells])


def prepared(arguments: argparse.Namespace) -> tuple[Scenario, Path]:
    """Return scenario and session folder; a mistake in the scenario leaves no folder behind."""
    scenario = cli.scenario_of(arguments)
    surroundings.check(scenario)
    return scenario, surroundings.new_folder(scenario.name, arguments.out)


def announce(console: Console, scenario: Scenario, folder: Path, *, live: bool) -> None:
    """Print what begins, and the prediction for it."""
    from pmwvc_analysis.prediction import text as prediction_text

    what = f"{scenario.duration_s:g} s {'live' if live else 'simulated'}"
    users = count(len(scenario.users), "user")
    console.print(f"{scenario.name}: {what}, {users}, {scenario.controller}")
    with doing("predicting"):
        lines = [*prediction_text.lines(scenario, live=live)]
    lines += [] if live else surroundings.notes(scenario)
    for line in lines:
        console.print(f"  {line}", markup=False)
    console.print(f"session folder: {folder}", markup=False)


def finish(
    console: Console,
    folder: Path,
    scenario: Scenario | None,
    *,
    check: bool,
    figures: bool = True,
    out: Path | None = None,
) -> cli.Result:
    """Judge and draw a recorded session and print the verdict; the document is its summary. With
    ``check`` the exit code is 1 where the session does not pass.
    """
    from pmwvc_analysis.session_files import REPORT, SUMMARY
    from pmwvc_analysis.session_files import finish as finish_files
    from pmwvc_view.recorded import replay_page

    with doing("reading the recording") as work:
        summary = finish_files(
            folder,
            scenario=scenario,
            out=out,
            player=replay_page,
            figures=figures,
            begins=work.part,
        )
    target, passed = out or folder, True
    lines = verdict_lines(summary)
    lines += [f"  {each['text']}" for each in summary["outcomes"] if each["hit"] is not False]
    lines.append(f"report: {target / REPORT}" if figures else f"numbers: {target / SUMMARY}")
    if check:
        passed = summary["check"]["passed"]
        lines.append(f"check: {'passed' if passed else 'FAILED'}")
        lines += [f"  {reason}" for reason in summary["check"]["reasons"]]
    for line in lines:
        console.print(line, markup=False)
    return cli.Result(0 if passed else 1, (target / SUMMARY).read_text("utf-8"))


def verdict_lines(summary: dict[str, Any]) -> list[str]:
    """Return the lines of the verdict, then what every user felt at the end."""
    from pmwvc_analysis.events import limits

    (first, *others), until = summary["verdict"], summary["judged_until_s"]
    text = first["text"]
    found = [f"{summary['scenario'] or 'session'}: {text[0].lower()}{text[1:]}"]
    found += [f"  {line['text']}" for line in others]
    for user in summary["users"]:
        parts = []
        if (force := user["force_final_n"]) is not None:
            when = f"at {until:.2f} s" if until < summary["duration_s"] else "at the end"
            when = f"when {user['ended']}" if user["ended"] else when
            axes = force if isinstance(force, list) else [force]
            turn = [each * summary["parameters"].get("server.lever_m", 1.0) for each in axes[3:]]
            torque = f", torque {' '.join(f'{each:z.4f}' for each in turn)} N m" if turn else ""
            parts.append(f"force {' '.join(f'{n:z.2f}' for n in axes[:3])} N{torque} {when}")
        if user["environment_limited"]:
            parts.append(limits.words(user["environment_limited"]))
        if user["ticks_missing"]:
            parts.append(f"{count(user['ticks_missing'], 'tick')} not recorded")
        found += [f"  {user['name']}: {'; '.join(parts)}."] if parts else []
    return found + [f"  {sentence}." for sentence in (summary["active"] or [])[:1]]
