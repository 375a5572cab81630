# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands that compare sessions: ``pmwvc compare``, one scenario over several parameters, and
``pmwvc replay``, a recorded session once more.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import doing, terminal
from pmwvc_core.words import count

if TYPE_CHECKING:
    from pmwvc_analysis.replay.run import Replay


EACH = "values of a parameter; may be repeated"
VALUES: Any = {"action": "append", "default": [], "metavar": "NAME=A,B,..."}


@cli.command(
    cli.SCENARIO, cli.USERS, cli.argument("--over", EACH, **VALUES),
    cli.DURATION.but("length of each session in s"),
    cli.SET.but("change a parameter of all; may be repeated"),
    cli.OUT.but("new or empty folder (default: sessions/<UTC time>-<scenario>-compare)"),
    cli.NO_FIGURES, cli.COMPARISON,
)  # fmt: skip
def compare(arguments: argparse.Namespace) -> cli.Result:
    """Run a scenario with several parameter values and compare the results.

    examples:
      pmwvc compare carry_16ms --over server.coupling=implicit,one_step_delay \\
                               --over link.delay_s=0,0.016,0.024
      pmwvc compare carry_16ms --over controller=pmwvc,direct --duration 8
      pmwvc compare wall_slow --over server.compensation=printed,corrected,ledger
      pmwvc compare stiff_24ms --over master.impedance=15,25,40 --out /tmp/impedances

    Every combination of the values runs in virtual time with the same hands and the same fate of
    every packet (one seed). The report names the tuning rules that baseline.NAME.* miss.
    """
    from pmwvc_bringup import comparison as report
    from pmwvc_bringup.session.surroundings import check, new_folder

    chosen = report.combinations(
        arguments.scenario,
        arguments.over,
        settings_texts=arguments.settings,
        users=arguments.users,
        duration_s=arguments.duration,
    )
    for one in chosen:
        check(one.scenario)
    name = chosen[0].scenario.name
    folder = new_folder(f"{name}-compare", arguments.out)
    console, figures = terminal(), arguments.figures
    console.print(f"{name}: {count(len(chosen), 'session')}, simulated")
    with doing("running") as work:
        entries = report.simulated(chosen, folder, work)
    return report.report(folder, f"Comparison of {name}", entries, console, figures=figures)


MISSES = "does NOT reproduce the recording"
HAND = (
    "the scenario's hand, which reacts, or the recorded force (default: operator where the device "
    "was simulated)"
)


@cli.command(
    cli.FOLDER, cli.SET, cli.argument("--hand", HAND, choices=("operator", "force")),
    cli.OUT.but("session folder, new or empty (default: sessions/<UTC time>-<scenario>-replay)"),
    cli.NO_FIGURES, cli.COMPARISON,
)  # fmt: skip
def replay_(arguments: argparse.Namespace) -> cli.Result:
    """Replay a recorded session in virtual time with other parameters.

    examples:
      pmwvc replay sessions/20260101T120000Z-carry_16ms --set master.impedance=40
      pmwvc replay sessions/20260101T120000Z-carry_16ms --set controller=direct --json
      pmwvc replay sessions/20260101T120000Z-carry_16ms --hand force

    Every packet meets the fate it met in the recording, and every loop runs when it ran. The hand
    is the one of the scenario, which reacts (--hand operator), or the recorded force (--hand
    force). A link whose parameters are set is simulated with them.
    """
    from pmwvc_analysis.recording.from_traces import record_traces
    from pmwvc_analysis.recording.reader import read_session
    from pmwvc_analysis.replay.run import replay
    from pmwvc_bringup.comparison import print_report
    from pmwvc_bringup.scenarios import load
    from pmwvc_bringup.session.surroundings import new_folder

    source = arguments.folder
    file = str(source / "scenario.yaml")
    recorded, replayed = load(file), load(file, settings_texts=arguments.settings)
    console, figures = terminal(), arguments.figures
    with doing("reading the recording") as work:
        traces = read_session(source)
        work.part("replaying")
        result = replay(traces, recorded, replayed, hand=arguments.hand, progress=work)
    folder = new_folder(f"{recorded.name}-replay", arguments.out)
    with doing("writing the recording") as work:
        record_traces(folder, result.replayed, result.scenario)
        work.part("writing the report")
        texts = _reported(result, source, folder, figures=figures)
    return print_report(folder, texts, console, figures=figures)


def _reported(result: "Replay", source: Path, folder: Path, *, figures: bool) -> list[str]:
    """Write summary, reports and tables; return the lines for a terminal."""
    from pmwvc_analysis.compare.measures import Compared, measured
    from pmwvc_analysis.replay.run import FORCE_N, POSITION_M, exact, reproduced
    from pmwvc_analysis.report.comparison import write
    from pmwvc_analysis.session_files import finish, write_summary
    from pmwvc_analysis.verdicts.check import state_text
    from pmwvc_analysis.verdicts.verdicts import summary

    if figures:
        finish(folder, result.replayed, result.scenario)
    else:
        write_summary(folder, summary(result.replayed, result.scenario))
    path = str(source.resolve())
    recorded = Compared("recorded", {}, result.recorded, result.recorded_scenario, path)
    replayed = Compared("replayed", result.changes, result.replayed, result.scenario, ".")
    before = result.recorded_scenario.flat()
    changes = {name: [before.get(name), new] for name, new in result.changes.items()}
    hands = result.prescribed.hands
    same = reproduced(result.differences) if not changes else None
    about = {
        "kind": "replay", "lead": lead(result, same), "recorded": path, "changes": changes,
        "differences": [{**user, "hand": hands[user["name"]]} for user in result.differences],
        "tolerance": {"force_n": FORCE_N, "position_m": POSITION_M},
        "exact": exact(result.differences) if not changes else None, "reproduced": same,
        "notes": result.prescribed.notes,
    }  # fmt: skip
    title = f"Replay of {result.recorded_scenario.name}"
    found = write(folder, title, [measured(recorded), measured(replayed)], about, figures=figures)
    states = [
        f"  {session['label']}: {state_text(session['stable'], session['instability'])}"
        for session in found["sessions"]
    ]
    notes = [f"  note: {note}" for note in found["notes"]]
    return [found["lead"], *states, *notes]


def lead(result: "Replay", same: bool | None) -> str:
    """Return the result in a sentence."""
    from pmwvc_analysis.replay.run import exact

    found = result.differences
    forces = [user["force_max_n"] for user in found]
    amount = "not all ticks can be compared"
    if forces and None not in forces and not any(user["missing"] for user in found):
        amount = f"forces differ by up to {max(forces):.3g} N"
    if same is None:
        names = ", ".join(f"{name} = {value}" for name, value in result.changes.items())
        return f"Replayed with {names}: {amount}."
    if exact(found):
        return "The unchanged replay is exact: force and position of all ticks are equal."
    word = "reproduces the recording, but is not exact" if same else MISSES
    apart = [user for user in found if user["first_s"] is not None]
    if first := min(apart, key=lambda user: user["first_s"], default=None):
        amount += f", from tick {first['first_tick']} of {first['name']} on"
    return f"The unchanged replay {word}: {amount}."
