# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc replay``: a recorded session once more, with other parameters."""

import argparse
import math
import time
from pathlib import Path
from typing import TYPE_CHECKING

from pmwvc_bringup.command import Result, argument, command
from pmwvc_bringup.options import FOLDER, NO_FIGURES, json_document, out, settings
from pmwvc_bringup.output import terminal
from pmwvc_bringup.progress import doing

if TYPE_CHECKING:
    from pmwvc_analysis.replay.run import Replay


KNOWN_S = 0.02  # after the first difference: a block is noted at its end
MOST = 3  # causes named


@command(
    "replay",
    "replay a recorded session in virtual time with other parameters",
    """\
examples:
  pmwvc replay sessions/20260101T120000Z-carry_16ms --set master.impedance=40
  pmwvc replay sessions/20260101T120000Z-carry_16ms --set controller=direct --json
  pmwvc replay sessions/20260101T120000Z-carry_16ms --hand force

Every packet meets the fate it met in the recording, and every loop runs when it ran. The hand is
the one of the scenario, which reacts (--hand operator), or the recorded force (--hand force).
A link whose parameters are set is simulated with them.
""",
    FOLDER,
    settings(),
    argument(
        "--hand",
        choices=("operator", "force"),
        help="the scenario's hand, which reacts, or the recorded force (default: operator "
        "where the device was simulated)",
    ),
    out("session folder, new or empty (default: sessions/<UTC time>-<scenario>-replay)"),
    NO_FIGURES,
    json_document("print comparison.json on stdout and nothing else"),
)
def replay_(arguments: argparse.Namespace) -> Result:
    """Replay, record and report."""
    from pmwvc_analysis.recording.from_traces import record_traces
    from pmwvc_analysis.recording.reader import read_session
    from pmwvc_analysis.replay.run import replay, scenario_of
    from pmwvc_bringup.comparison.report import print_report
    from pmwvc_bringup.scenarios import load
    from pmwvc_bringup.session.surroundings import new_folder

    source = Path(arguments.folder)
    scenario_of(source)  # refuses a folder without a scenario
    file = str(source / "scenario.yaml")
    recorded, replayed = load(file), load(file, settings_texts=arguments.settings)
    console, figures = terminal(), not arguments.no_figures
    with doing("reading the recording") as work:
        traces = read_session(source)
        work.part("replaying")
        begin = time.perf_counter()
        result = replay(traces, recorded, replayed, hand=arguments.hand, progress=work)
        times_real_time = result.replayed.duration_s / (time.perf_counter() - begin)
    folder = new_folder(f"{recorded.name}-replay", arguments.out)
    with doing("writing the recording") as work:
        record_traces(folder, result.replayed, result.scenario, metadata=result.metadata())
        work.part("writing the report")
        texts = _reported(result, source, folder, times_real_time, figures=figures)
    return print_report(folder, texts, console, figures=figures)


def _reported(
    result: "Replay", source: Path, folder: Path, times_real_time: float, *, figures: bool
) -> list[str]:
    """Write summary, reports and tables; return the lines for a terminal."""
    from pmwvc_analysis.compare.measures import Entry, measured
    from pmwvc_analysis.replay.run import FORCE_N, POSITION_M, exact, reproduced
    from pmwvc_analysis.report.comparison_report import write
    from pmwvc_analysis.session_files import finish, write_summary
    from pmwvc_analysis.verdicts.check import state_text
    from pmwvc_analysis.verdicts.verdicts import summary

    if figures:
        finish(folder, result.replayed, result.scenario)
    else:
        write_summary(folder, summary(result.replayed, result.scenario))
    path = str(source.resolve())
    entries = [
        measured(Entry("recorded", {}, result.recorded, result.recorded_scenario, path)),
        measured(Entry("replayed", result.changes, result.replayed, result.scenario, ".")),
    ]
    before = result.recorded_scenario.flat()
    changes = {name: [before.get(name), new] for name, new in result.changes.items()}
    same = reproduced(result.differences) if not changes else None
    about = {
        "kind": "replay",
        "lead": lead(result, same),
        "recorded": path,
        "changes": changes,
        "differences": [
            {**user, "hand": result.prescribed.hands[user["name"]]} for user in result.differences
        ],
        "tolerance": {"force_n": FORCE_N, "position_m": POSITION_M},
        "exact": exact(result.differences) if not changes else None,
        "reproduced": same,
        "limits": [limit._asdict() for limit in result.limits],
        "times_real_time": times_real_time,
        "notes": result.prescribed.notes,
    }
    title = f"Replay of {result.recorded_scenario.name}"
    found = write(folder, title, entries, about, figures=figures)
    states = [
        f"  {session['label']}: {state_text(session['stable'], session['instability'])}"
        for session in found["sessions"]
    ]
    notes = [f"  note: {note}" for note in found["notes"]]
    return [found["lead"], *states, *notes, f"  {times_real_time:.0f} times real time"]


def lead(result: "Replay", same: bool | None) -> str:
    """Return the result in one sentence or two."""
    from pmwvc_analysis.replay.run import exact

    found = result.differences
    forces = [user["force_max_n"] for user in found]
    if not forces or None in forces:
        amount = "not all forces can be compared"
    else:
        amount = f"forces differ by up to {max(forces):.3g} N"
    if same is None:
        names = ", ".join(f"{name} = {value}" for name, value in result.changes.items())
        return f"Replayed with {names}: {amount}."
    if exact(found):
        ticks = ", ".join(f"{user['ticks']} ticks of {user['name']}" for user in found)
        return f"The unchanged replay is exact: force and position of all {ticks} are equal."
    word = (
        "reproduces the recording, but is not exact"
        if same
        else "does NOT reproduce the recording"
    )
    return f"The unchanged replay {word}: {amount}{_since(result)}."


def _since(result: "Replay") -> str:
    """Return from which tick on a replay is not the recording, and why."""
    apart = [user for user in result.differences if user["first_s"] is not None]
    missing = [user for user in result.differences if user["missing"]]
    if apart:
        first = min(apart, key=lambda user: user["first_s"])
        at_s = first["first_s"]
        signals = ", ".join(first["first_signals"])
        text = f", from tick {first['first_tick']} of {first['name']} on ({at_s:.3f} s; {signals})"
    elif missing:
        ticks = " and ".join(f"{user['missing']} ticks of {user['name']}" for user in missing)
        text, at_s = f"; {ticks} cannot be compared", math.inf
    else:
        return ""
    causes = [limit for limit in result.limits if limit.time_s <= at_s + KNOWN_S]
    whys = "; ".join(f"{each.why} ({each.time_s:.3f} s)" for each in causes[:MOST])
    more = f"; and {len(causes) - MOST} more" if len(causes) > MOST else ""
    return f"{text}. {'Why: ' + whys + more if causes else 'The recording gives no reason'}"
