# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Texts of a session on the terminal: the prediction before it, and the verdict after it."""

import argparse
import os
from pathlib import Path
from typing import Any

from rich.console import Console

from pmwvc_bringup.command import Result
from pmwvc_bringup.options import scenario_of
from pmwvc_bringup.progress import doing
from pmwvc_bringup.session import preflight
from pmwvc_bringup.session.surroundings import new_folder
from pmwvc_core.plural import count
from pmwvc_core.scenario.scenario import Scenario


def prepared(arguments: argparse.Namespace) -> tuple[Scenario, Path]:
    """Return scenario and session folder; a mistake in the scenario leaves no folder behind."""
    scenario = scenario_of(arguments)
    preflight.check(scenario)
    return scenario, new_folder(scenario.name, arguments.out)


def announce(console: Console, scenario: Scenario, folder: Path, *, live: bool) -> None:
    """Print what begins, and the prediction for it."""
    from pmwvc_analysis.prediction import text as prediction_text

    kind = "live" if live else "simulated"
    users = count(len(scenario.users), "user")
    console.print(
        f"{scenario.name}: {scenario.duration_s:g} s {kind}, {users}, {scenario.controller}"
    )
    with doing("predicting"):
        lines = list(prediction_text.lines(scenario, live=live))
    if live:
        cores = len(os.sched_getaffinity(0))
        lines += preflight.too_much(scenario, cores=cores, busy=os.getloadavg()[0])
    else:
        lines += preflight.notes(scenario)
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
) -> Result:
    """Judge and draw a recorded session and print the verdict; the document is its summary.

    With ``check`` the exit code is 1 where the session does not pass.
    """
    from pmwvc_analysis.session_files import REPORT, SUMMARY
    from pmwvc_analysis.session_files import finish as finish_files
    from pmwvc_view.recorded.replay_page import replay_page

    with doing("reading the recording") as work:
        summary = finish_files(
            folder,
            scenario=scenario,
            out=out,
            player=replay_page,
            figures=figures,
            begins=work.part,
        )
    target = out or folder
    lines = verdict_lines(summary)
    lines += [f"  {outcome['text']}" for outcome in summary["outcomes"]]
    lines.append(f"report: {target / (REPORT if figures else SUMMARY)}")
    passed = True
    if check:
        passed = summary["check"]["passed"]
        lines.append(f"check: {'passed' if passed else 'FAILED'}")
        lines += [f"  {reason}" for reason in summary["check"]["reasons"]]
    for line in lines:
        console.print(line, markup=False)
    return Result(0 if passed else 1, (target / SUMMARY).read_text("utf-8"))


def verdict_lines(summary: dict[str, Any]) -> list[str]:
    """Return the result in sentences, one line for the session and one per user."""
    from pmwvc_analysis.events import limits
    from pmwvc_analysis.verdicts import check

    state = check.state_text(summary["stable"], summary["instability"])
    if summary["stable"] is None:
        state += f": {summary['stability']['text']}"
    until = summary["judged_until_s"]
    cut = until < summary["duration_s"]
    found = [
        f"{summary['scenario'] or 'session'}: {state}{f' until {until:.2f} s' if cut else ''}"
    ]
    found += [f"  Interrupted: {text}" for text in summary["interrupted"]]
    found += [f"  Another publisher: {text}" for text in summary["strangers"]]
    texts = summary["passivity"]["text"]
    for user in summary["users"]:
        parts = [texts[user["name"]]]
        if user["force_final_n"] is not None:
            when = f"at {until:.2f} s" if cut else "at the end"
            when = f"when {user['ended']}" if user["ended"] else when
            force = user["force_final_n"]
            axes = force if isinstance(force, list) else [force]
            parts.append(f"force {' '.join(f'{number:.2f}' for number in axes)} N {when}")
        if user["environment_limited"]:
            parts.append(limits.words(user["environment_limited"]))
        if user["ticks_missing"]:
            parts.append(f"{count(user['ticks_missing'], 'tick')} not recorded")
        found.append(f"  {user['name']}: {'; '.join(parts)}")
    found += [f"  {who}: {text}" for who, text in check.disturbances(summary).items()]
    noted = [*check.interventions(summary), *check.kept_apart(summary)]
    found += [f"  {line['text']}" for line in noted]
    if summary["recording"]["holes"]:
        found.append(f"  {check.hole_text(summary)}; nothing is judged there")
    if "server" in texts:
        found.append(f"  server: {texts['server']}")
    return found + [f"  {sentence}" for sentence in (summary["active"] or [])[:1]]
