# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What the sub-commands do. Heavy imports stand inside: ``pmwvc --help`` is to answer at once."""

import argparse
import os
import sys
import textwrap
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from pmwvc_bringup import scenarios as files
from pmwvc_bringup.output import document
from pmwvc_bringup.session import plan, preflight
from pmwvc_core.errors import PmwvcError
from pmwvc_core.network.presets import PRESETS
from pmwvc_core.plural import count
from pmwvc_core.scenario.scenario import Scenario

NODES = plan.MODULES
WIDTH = 99


def run(arguments: argparse.Namespace) -> int:
    """Run a live session; 1 when a node did not come up, 130 when ended before it began."""
    preflight.require_ros()
    scenario, folder = _prepared(arguments)
    from pmwvc_bringup.session.runner import LiveSession, StartError

    with document(wanted=arguments.json) as write:
        console = _console()
        _announce(console, scenario, folder, live=True)
        try:
            if not LiveSession(scenario, folder, console=console).run():
                print("pmwvc: ended before the session began", file=sys.stderr)
                return 130
        except StartError as error:
            print(f"pmwvc: {error}", file=sys.stderr)
            return 1
        return _finished(console, folder, scenario, write=write, check=arguments.check)


def simulate(arguments: argparse.Namespace) -> int:
    """Run a session in virtual time, and record and report it as a live one."""
    scenario, folder = _prepared(arguments)
    from rich.progress import Progress

    from pmwvc_analysis.recording.from_traces import record_traces
    from pmwvc_core.simulation.session import simulate as run_batch

    with document(wanted=arguments.json) as write:
        console = _console()
        _announce(console, scenario, folder, live=False)
        with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task("simulating", total=1.0)
            (traces,) = run_batch(
                [scenario], progress=lambda share: bar.update(task, completed=share)
            )
        fault = traces.metadata.get("environment")
        if fault is not None:
            steps = count(fault["contained_steps"], "step")
            text = f"a damper replaced the environment in {steps}: {fault['last_fault']}"
            console.print(f"  Warning: {text}", markup=False)
        record_traces(folder, traces, scenario, metadata={"environment": fault} if fault else {})
        return _finished(console, folder, scenario, write=write, check=arguments.check)


def report(arguments: argparse.Namespace) -> int:
    """Judge a recorded session (or those of a comparison) anew and write its report."""
    from pmwvc_analysis.compare.on_disk import is_comparison

    folder = Path(arguments.folder)
    if is_comparison(folder):
        from pmwvc_bringup.compare_command import again

        if arguments.check:
            raise PmwvcError(f"--check judges one session: name a folder in {folder / 'runs'}")
        if arguments.out:
            raise PmwvcError(f"{folder} is a comparison: its report is written into it, not --out")
        return again(folder, json_wanted=arguments.json)
    out = Path(arguments.out).expanduser() if arguments.out else None
    with document(wanted=arguments.json) as write:
        return _finished(_console(), folder, None, write=write, check=arguments.check, out=out)


def node(arguments: argparse.Namespace) -> int:
    """Become one node: same process, so that signals and exit code are the node's own.

    With ``--help``, print its parameters instead.
    """
    preflight.require_ros()
    if {"-h", "--help"} & set(arguments.arguments):
        from pmwvc_bringup import node_help

        print(node_help.text(arguments.kind))
        return 0
    from pmwvc_bringup.session.surroundings import LOCALHOST, RANGE, own_environment

    words = [sys.executable, "-m", NODES[arguments.kind], *arguments.arguments]
    os.execve(sys.executable, words, own_environment({RANGE: LOCALHOST, **os.environ}))


def scenarios(arguments: argparse.Namespace) -> int:
    """List the scenarios and the networks, or print a complete scenario."""
    with document(wanted=arguments.json) as write:
        if arguments.name:
            scenario = files.load(arguments.name)
            sys.stdout.write(files.to_yaml(scenario))
            write(scenario.to_dict())
            return 0
        known = [files.load(name) for name in files.known()]
        for scenario in known:
            print(_entry(scenario.name, scenario.description))
        print()
        print(_entry("networks", "for --set link.preset=NAME: " + ", ".join(PRESETS) + "."))
        write({"scenarios": [_about(scenario) for scenario in known], "networks": list(PRESETS)})
    return 0


def _entry(name: str, text: str) -> str:
    """Return a name and what it means, indented."""
    indent = " " * 25
    return textwrap.fill(text, WIDTH, initial_indent=f"{name:24} ", subsequent_indent=indent)


def _about(scenario: Scenario) -> dict[str, Any]:
    """Return what a list of scenarios says of one."""
    return {
        "name": scenario.name,
        "description": scenario.description,
        "controller": scenario.controller,
        "users": len(scenario.users),
        "dof": scenario.dof,
        "duration_s": scenario.duration_s,
    }


def doctor(arguments: argparse.Namespace) -> int:
    """Examine the machine (1 when there is a problem) or a recording.

    A recording gives 0 when it is complete, 2 when it is but for losses it declares, 3 when it is
    damaged.
    """
    if arguments.mend and not arguments.folder:
        raise PmwvcError("--mend: name the damaged session folder as well")
    with document(wanted=arguments.json) as write:
        if arguments.mend:
            findings, code = _mended(Path(arguments.folder), Path(arguments.mend).expanduser())
        elif arguments.folder:
            findings, code = _recording_findings(Path(arguments.folder))
        else:
            from pmwvc_bringup.machine import examine

            findings = examine()
            code = int(any(finding.status == "problem" for finding in findings))
        for finding in findings:
            print(finding.line())
        write({"exit_code": code, "findings": [asdict(finding) for finding in findings]})
    return code


def _mended(folder: Path, target: Path) -> tuple[list[Any], int]:
    from pmwvc_analysis.doctor import check_recording, exit_code
    from pmwvc_analysis.recording.recover import mend

    print(mend(folder, target))
    findings = check_recording(target)
    return findings, exit_code(findings)


def _recording_findings(folder: Path) -> tuple[list[Any], int]:
    from pmwvc_analysis.doctor import check_recording, exit_code

    if not folder.exists():
        raise PmwvcError(f"{folder}: there is no such session folder")
    from pmwvc_analysis.compare.on_disk import is_comparison, session_folders

    if not is_comparison(folder):
        findings = check_recording(folder)
        return findings, exit_code(findings)
    findings = [
        replace(finding, text=f"{place.name}: {finding.text}")
        for place in session_folders(folder)
        for finding in check_recording(place)
    ]
    return findings, exit_code(findings)


def _prepared(arguments: argparse.Namespace) -> tuple[Scenario, Path]:
    """Return scenario and session folder; a mistake in the scenario leaves no folder behind."""
    from pmwvc_bringup.session.surroundings import new_folder

    scenario = files.load(
        arguments.scenario,
        settings_texts=arguments.settings,
        users=arguments.users,
        duration_s=arguments.duration,
    )
    preflight.check(scenario)
    return scenario, new_folder(scenario.name, arguments.out)


def _console() -> Console:
    return Console(highlight=False, soft_wrap=True)


def _announce(console: Console, scenario: Scenario, folder: Path, *, live: bool) -> None:
    """Say what begins, and what the numbers promise before it does."""
    from pmwvc_analysis.prediction import prediction_words

    kind = "live" if live else "simulated"
    users = count(len(scenario.users), "user")
    console.print(
        f"{scenario.name}: {scenario.duration_s:g} s {kind}, {users}, {scenario.controller}"
    )
    for line in prediction_words.lines(scenario, live=live) + (
        [] if live else preflight.notes(scenario)
    ):
        console.print(f"  {line}", markup=False)
    console.print(f"session folder: {folder}", markup=False)


def _finished(
    console: Console,
    folder: Path,
    scenario: Scenario | None,
    *,
    write: Callable[[str], None],
    check: bool,
    out: Path | None = None,
) -> int:
    """Judge and draw what is recorded, print the verdict, write the summary; return the exit code:
    with ``check``, 1 where the session does not pass.
    """
    from pmwvc_analysis.session_files import REPORT, SUMMARY, finish

    summary = finish(folder, scenario=scenario, out=out)
    for line in _verdict(summary):
        console.print(line, markup=False)
    for outcome in summary["outcomes"]:
        console.print(f"  {outcome['text']}", markup=False)
    target = out or folder
    console.print(f"report: {target / REPORT}", markup=False)
    write((target / SUMMARY).read_text("utf-8"))
    if not check:
        return 0
    passed = summary["check"]["passed"]
    console.print(f"check: {'passed' if passed else 'FAILED'}", markup=False)
    for reason in summary["check"]["reasons"]:
        console.print(f"  {reason}", markup=False)
    return 0 if passed else 1


def _verdict(summary: dict[str, Any]) -> list[str]:
    """Return the result in sentences, one line for the session and one per user."""
    from pmwvc_analysis.events import environment
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
            parts.append(f"force {_vector(user['force_final_n'])} N {when}")
        if user["environment_limited"]:
            parts.append(environment.words(user["environment_limited"]))
        if user["ticks_missing"]:
            parts.append(f"{count(user['ticks_missing'], 'tick')} not recorded")
        found.append(f"  {user['name']}: {'; '.join(parts)}")
    found += [f"  {line['text']}" for line in check.interventions(summary)]
    if summary["recording"]["holes"]:
        found.append(f"  {check.hole_text(summary)}; nothing is judged there")
    if "server" in texts:
        found.append(f"  server: {texts['server']}")
    return found + [f"  {sentence}" for sentence in (summary["active"] or [])[:1]]


def _vector(value: float | list[float]) -> str:
    """Return a number, or one per axis."""
    values = value if isinstance(value, list) else [value]
    return " ".join(f"{number:.2f}" for number in values)
