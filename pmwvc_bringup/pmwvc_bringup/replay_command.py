# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc replay``: a recorded session once more, with other parameters.

Heavy imports stand inside, as in :mod:`pmwvc_bringup.commands`.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any

from rich.console import Console

from pmwvc_bringup import scenarios as files
from pmwvc_bringup.options import add_json, add_settings
from pmwvc_bringup.output import document

EXAMPLES = """\
examples:
  pmwvc replay sessions/20260101T120000Z-carry_16ms --set master.impedance=40
  pmwvc replay sessions/20260101T120000Z-carry_16ms --set controller=direct --json
  pmwvc replay sessions/20260101T120000Z-carry_16ms --hand force

Every packet meets the fate it met in the recording, and every loop runs when it ran. The hand is
the one of the scenario, which reacts (--hand operator), or the recorded force (--hand force).
A link whose parameters are set is simulated with them.
"""


def add(several: Any) -> None:
    """Add the command to the sub-commands of a parser."""
    text = "replay a recorded session in virtual time with other parameters"
    parser = several.add_parser("replay", help=text, description=f"{text}.", epilog=EXAMPLES)
    parser.set_defaults(command=run)
    parser.add_argument("folder", metavar="FOLDER", help="a session folder")
    add_settings(parser)
    parser.add_argument(
        "--hand",
        choices=("operator", "force"),
        help="the scenario's hand, which reacts, or the recorded force (default: operator where "
        "the device was simulated)",
    )
    parser.add_argument(
        "--out",
        metavar="FOLDER",
        help="session folder, new or empty (default: sessions/<UTC time>-<scenario>-replay)",
    )
    parser.add_argument("--no-figures", action="store_true", help="write numbers only")
    add_json(parser, "print comparison.json on stdout and nothing else")


def run(arguments: argparse.Namespace) -> int:
    """Replay, record and report."""
    from rich.progress import Progress

    from pmwvc_analysis.recording.from_traces import record_traces
    from pmwvc_analysis.recording.reader import read_session
    from pmwvc_analysis.replay.run import replay_traces, scenario_of
    from pmwvc_bringup.session.surroundings import new_folder

    source = Path(arguments.folder)
    scenario_of(source)  # says what is missing
    file = str(source / "scenario.yaml")
    recorded, replayed = files.load(file), files.load(file, settings_texts=arguments.settings)
    with document(wanted=arguments.json) as write:
        console = Console(highlight=False, soft_wrap=True)
        traces = read_session(source)
        with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task("replaying", total=1.0)
            begin = time.perf_counter()
            result = replay_traces(
                traces,
                recorded,
                replayed,
                hand=arguments.hand,
                progress=lambda share: bar.update(task, completed=share),
            )
            faster = result.replayed.duration_s / (time.perf_counter() - begin)
        folder = new_folder(f"{recorded.name}-replay", arguments.out)
        record_traces(folder, result.replayed, result.scenario, metadata=result.metadata())
        found = _reported(result, source, folder, faster, figures=not arguments.no_figures)
        for line in _lines(found):
            console.print(line, markup=False)
        page = "comparison.json" if arguments.no_figures else "comparison.html"
        console.print(f"report: {folder / page}", markup=False)
        write(json.dumps(found, indent=2, ensure_ascii=False, allow_nan=False))
    return 0


def _reported(
    result: Any, source: Path, folder: Path, faster: float, *, figures: bool
) -> dict[str, Any]:
    """Write summary, reports and tables; return what ``comparison.json`` holds."""
    from pmwvc_analysis.compare.measures import Entry, measured
    from pmwvc_analysis.replay.differences import FORCE_N, POSITION_M, reproduced
    from pmwvc_analysis.report.comparison_report import write
    from pmwvc_analysis.session_files import finish, write_summary
    from pmwvc_analysis.verdicts.verdicts import summary

    if figures:
        finish(folder, result.replayed, result.scenario)
    else:
        write_summary(folder, summary(result.replayed, result.scenario))
    entries = [
        measured(
            Entry("recorded", {}, result.recorded, result.recorded_scenario, str(source.resolve()))
        ),
        measured(Entry("replayed", result.changes, result.replayed, result.scenario, ".")),
    ]
    before = result.recorded_scenario.flat()
    changes = {name: [before.get(name), new] for name, new in result.changes.items()}
    same = reproduced(result.differences) if not changes else None
    about = {
        "kind": "replay",
        "lead": _lead(result, same),
        "recorded": str(source.resolve()),
        "changes": changes,
        "differences": [
            {**user, "hand": result.prescribed.hands[user["name"]]} for user in result.differences
        ],
        "tolerance": {"force_n": FORCE_N, "position_m": POSITION_M},
        "reproduced": same,
        "times_real_time": faster,
        "notes": result.prescribed.notes,
    }
    return write(
        folder, f"Replay of {result.recorded_scenario.name}", entries, about, figures=figures
    )


def _lead(result: Any, same: bool | None) -> str:
    """Return the result in one sentence."""
    forces = [user["force_max_n"] for user in result.differences]
    if not forces or None in forces:
        amount = "not all forces can be compared"
    elif not any(forces):
        amount = "the forces are equal"
    else:
        amount = f"forces differ by up to {max(forces):.3g} N"
    if same is None:
        names = ", ".join(f"{name} = {value}" for name, value in result.changes.items())
        return f"Replayed with {names}: {amount}."
    word = "reproduces" if same else "does NOT reproduce"
    return f"The unchanged replay {word} the recording: {amount}."


def _lines(found: dict[str, Any]) -> list[str]:
    """Return what a person reads on the terminal."""
    from pmwvc_analysis.verdicts.check import state_text

    lines = [found["lead"]]
    for session in found["sessions"]:
        state = state_text(session["stable"], session["instability"])
        lines.append(f"  {session['label']}: {state}")
    lines += [f"  note: {note}" for note in found["notes"]]
    lines.append(f"  {found['times_real_time']:.0f} times real time")
    return lines
