# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc compare``: one scenario over several parameters, everything else the same.

Heavy imports stand inside, as in :mod:`pmwvc_bringup.commands`.
"""

import argparse
import json
import re
from pathlib import Path
from typing import Any

from rich.console import Console

from pmwvc_bringup.combinations import Combination, combinations
from pmwvc_bringup.options import add_json, add_scenario, add_settings
from pmwvc_bringup.output import document
from pmwvc_bringup.scenarios import to_yaml
from pmwvc_bringup.variants import fitting, words_of
from pmwvc_core.errors import PmwvcError
from pmwvc_core.plural import count

EXAMPLES = """\
examples:
  pmwvc compare carry_16ms --over server.coupling=implicit,one_step_delay \\
                           --over link.delay_s=0,0.016,0.024
  pmwvc compare carry_16ms --controllers pmwvc,direct --duration 8
  pmwvc compare wall_slow --controllers direct,waves,printed,corrected,ledger
  pmwvc compare stiff_24ms --over master.impedance=15,25,40 --live --out /tmp/impedances

--controllers takes pmwvc (the scenario's own settings), direct, virtual_coupling, tdpa, pspm, and
waves (plain), or features on plain waves, joined by +: printed, corrected, ledger (compensation of
an unknown environment decoded late), secant (ledger behind a learned slope), velocity_filter,
velocity_filter_printed, filter_bank, complementary_bank, position, position_printed,
position_integral. What a scenario does not allow is left out with a note.

Every combination of the values runs with the same hands and the same fate of every packet (one
seed), in virtual time or, with --live, as nodes one session after the other. virtual_coupling,
tdpa and pspm are tuned by their rules for each combination, unless baseline.NAME.* is set.
"""


def add(several: Any) -> None:
    """Add the command to the sub-commands of a parser."""
    text = "run a scenario with several parameter values and compare the results"
    parser = several.add_parser("compare", help=text, description=f"{text}.", epilog=EXAMPLES)
    parser.set_defaults(command=run)
    add_scenario(parser)
    parser.add_argument(
        "--over",
        action="append",
        default=[],
        metavar="NAME=A,B,...",
        help="values of a parameter; may be repeated",
    )
    parser.add_argument("--controllers", metavar="A,B,...", help="controllers by name; see below")
    parser.add_argument("--duration", type=float, metavar="S", help="length of each session in s")
    add_settings(parser, what="a parameter of all")
    parser.add_argument("--live", action="store_true", help="real nodes instead of virtual time")
    parser.add_argument(
        "--out",
        metavar="FOLDER",
        help="new or empty folder (default: sessions/<UTC time>-<scenario>-compare)",
    )
    parser.add_argument("--no-figures", action="store_true", help="write numbers only")
    add_json(parser, "print comparison.json on stdout and nothing else")


def run(arguments: argparse.Namespace) -> int:
    """Run every combination, record each, and report all of them together."""
    from rich.progress import Progress

    from pmwvc_bringup.session.surroundings import new_folder

    words, left_out = fitting(
        arguments.scenario, words_of(arguments.controllers), arguments.settings
    )
    notes = [f"Left out: {word}: {why}." for word, why in left_out.items()]
    chosen = combinations(
        arguments.scenario,
        arguments.over,
        controllers=words,
        settings_texts=arguments.settings,
        users=arguments.users,
        duration_s=arguments.duration,
    )
    name = chosen[0].scenario.name
    folder = new_folder(f"{name}-compare", arguments.out)
    with document(wanted=arguments.json) as write:
        console = Console(highlight=False, soft_wrap=True)
        console.print(
            f"{name}: {count(len(chosen), 'session')}, {'live' if arguments.live else 'simulated'}"
        )
        with Progress(
            console=console, transient=True, disable=arguments.live or not console.is_terminal
        ) as bar:
            task = bar.add_task("running", total=1.0)

            def show(share: float) -> None:
                bar.update(task, completed=share)

            places = [_place(number, one) for number, one in enumerate(chosen, start=1)]
            if arguments.live:
                entries = _live(chosen, places, folder, console)
            else:
                entries = _simulated(chosen, places, folder, show)
        title, figures = f"Comparison of {name}", not arguments.no_figures
        found = reported(folder, title, entries, notes=notes, figures=figures)
        for line in [*lines(found), *notes]:
            console.print(line, markup=False)
        page = "comparison.json" if arguments.no_figures else "comparison.html"
        console.print(f"report: {folder / page}", markup=False)
        write(json.dumps(found, indent=2, ensure_ascii=False, allow_nan=False))
    return 0


def _place(number: int, one: Combination) -> str:
    """Return the folder of a session below that of the comparison."""
    plain = re.sub(r"[^A-Za-z0-9_.=-]+", "_", one.label.replace(" = ", "="))[:60]
    return f"runs/{number:02d}-{plain}"


def _simulated(chosen: list[Combination], places: list[str], folder: Path, show: Any) -> list[Any]:
    """Simulate all, batched; write each as a session without pictures."""
    from pmwvc_analysis.compare.measures import Entry, measured
    from pmwvc_analysis.recording.from_traces import record_traces
    from pmwvc_analysis.session_files import write_summary
    from pmwvc_analysis.verdicts.verdicts import summary
    from pmwvc_core.simulation.session import simulate

    traces = simulate(
        [one.scenario for one in chosen],
        keep=lambda kept: kept,
        progress=lambda share: show(0.5 * share),
    )
    entries = []
    for number, (one, each, place) in enumerate(zip(chosen, traces, places, strict=True)):
        record_traces(folder / place, each, one.scenario)
        write_summary(folder / place, summary(each, one.scenario))
        entries.append(measured(Entry(one.label, one.settings, each, one.scenario, place)))
        show(0.5 + 0.5 * (number + 1) / len(chosen))
    return entries


def _live(
    chosen: list[Combination], places: list[str], folder: Path, console: Console
) -> list[Any]:
    """Run one session of nodes after the other, each by a runner of its own."""
    import subprocess
    import sys
    import tempfile

    from pmwvc_analysis.compare.measures import Entry, measured
    from pmwvc_analysis.recording.reader import read_session

    entries: list[Entry] = []
    for one, place in zip(chosen, places, strict=True):
        console.print(f"{len(entries) + 1} of {len(chosen)}: {one.label}", markup=False)
        with tempfile.TemporaryDirectory() as scratch:
            file = Path(scratch, "scenario.yaml")
            file.write_text(to_yaml(one.scenario), "utf-8")
            words = ["run", str(file), "--out", str(folder / place)]
            command = [sys.executable, "-m", "pmwvc_bringup.cli", *words]
            code = subprocess.run(command, check=False).returncode
        if code == 130:
            raise KeyboardInterrupt
        if code:
            raise PmwvcError(f"{one.label}: the session did not run (exit code {code}); see above")
        traces = read_session(folder / place)
        entries.append(measured(Entry(one.label, one.settings, traces, one.scenario, place)))
    return entries


def reported(
    folder: Path, title: str, entries: list[Any], *, notes: list[str], figures: bool
) -> dict[str, Any]:
    """Write tables and report of a comparison; return what ``comparison.json`` holds."""
    from pmwvc_analysis.report.comparison_report import write

    about = {"kind": "comparison", "lead": "", "notes": notes}
    return write(folder, title, entries, about, figures=figures)


def again(folder: Path, *, json_wanted: bool) -> int:
    """Judge the sessions of a comparison anew and write its report."""
    from pmwvc_analysis.compare.on_disk import read_comparison, read_entries

    with document(wanted=json_wanted) as write:
        console = Console(highlight=False, soft_wrap=True)
        before = read_comparison(folder)
        title, notes = str(before["title"]), list(before.get("notes", []))
        found = reported(folder, title, read_entries(folder), notes=notes, figures=True)
        for line in lines(found):
            console.print(line, markup=False)
        console.print(f"report: {folder / 'comparison.html'}", markup=False)
        write(json.dumps(found, indent=2, ensure_ascii=False, allow_nan=False))
    return 0


def lines(found: dict[str, Any]) -> list[str]:
    """Return the table of a comparison for a terminal."""
    sessions = found["sessions"]
    width = max(len("session"), *(len(session["label"]) for session in sessions))
    heads = (
        "K max [N/m]",
        "rendered [N/m]",
        "peak [Hz]",
        "free [kg]",
        "free [N s/m]",
        "offset [mm]",
        "force err [N]",
        "balance [mJ]",
        "noise [mN]",
    )
    names = (
        "k_max",
        "k_felt",
        "first_peak_hz",
        "mass_free_kg",
        "damping_free_n_s_m",
        "coherency_rms_m",
        "force_error_rms_n",
        "energy_min_j",
        "force_noise_n",
    )
    factors = (1.0, 1.0, 1.0, 1.0, 1.0, 1e3, 1.0, 1e3, 1e3)
    table = [f"{'session':{width}}  " + "  ".join(f"{head:>14}" for head in heads) + "  verdict"]
    for session in sessions:
        numbers = [
            "-" if session[name] is None else f"{session[name] * factor:.4g}"
            for name, factor in zip(names, factors, strict=True)
        ]
        verdict = "stable" if session["stable"] else session["instability"] or "not judged"
        verdict += "" if session["passive"] is not False else ", not passive"
        cells = "  ".join(f"{number:>14}" for number in numbers)
        table.append(f"{session['label']:{width}}  {cells}  {verdict}")
    return [*table, *_parameter_lines(sessions, width), *found["conclusion"]]


def _parameter_lines(sessions: list[dict[str, Any]], width: int) -> list[str]:
    """Return the parameters that each controller ran with, a line per session."""
    table = [f"{'':{width}}  parameters"]
    for session in sessions:
        given = ", ".join(f"{n}={_short(v)}" for n, v in session["parameters"].items())
        tuning = f" ({session['tuning']})" if session["tuning"] else ""
        table.append(f"{session['label']:{width}}  {given or 'none'}{tuning}")
    return table


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
