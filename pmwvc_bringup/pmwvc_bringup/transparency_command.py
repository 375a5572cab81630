# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc transparency``: what a user feels through the link, from the model and as recorded.

Heavy imports stand inside, as in :mod:`pmwvc_bringup.commands`.
"""

import argparse
import json
from pathlib import Path
from typing import Any

from pmwvc_bringup import scenarios as files
from pmwvc_bringup.options import add_json, add_model_options
from pmwvc_bringup.output import document
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.scenario import Scenario

EXAMPLES = """\
examples:
  pmwvc transparency carry_16ms
  pmwvc transparency wall --set master.impedance=80 --json
  pmwvc transparency wall --set operator.kind=chirp --out /tmp/felt
  pmwvc transparency sessions/20260101T120000Z-wall --out /tmp/felt

A session folder adds the estimate from its recording (operator.kind chirp, sinusoid or a played
force). --out writes transparency.png, .svg, .csv, .npz, .mat and .json.

Keys of --json: scenario, user, admittance_dc (m/N at rest), k_felt (its inverse), b_felt (N s/m,
pressing, device included), mass_felt (kg, nothing touched, device included), first_peak_hz, ideal
(the same five for direct coupling at every tick, no delay), measured (null, or points, trusted,
stretches, from_hz, to_hz, coherence_median, error_median), notes. null: there is no such limit.
"""


def add(several: Any) -> None:
    """Add the command to the sub-commands of a parser."""
    text = "compute the stiffness, damping and mass rendered to a user, beside an ideal link"
    parser = several.add_parser("transparency", help=text, description=f"{text}.", epilog=EXAMPLES)
    parser.set_defaults(command=run)
    add_model_options(parser)
    parser.add_argument(
        "--user", metavar="NAME", dest="whose", help="user to analyse (default: the first)"
    )
    parser.add_argument("--out", metavar="FOLDER", help="folder for figure, curves and numbers")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Answer."""
    folder = Path(arguments.scenario)
    recorded = folder.is_dir()
    with document(wanted=arguments.json) as write:
        scenario = _scenario_of(arguments, folder if recorded else None)
        place = _place(scenario, arguments.whose)
        from pmwvc_analysis.models.multirate import build
        from pmwvc_analysis.transparency.answer import answer, sentences
        from pmwvc_analysis.transparency.frequency import response
        from pmwvc_analysis.transparency.transparency import pressing, transparency

        measured = model = None
        forces: list[float] = []
        live = arguments.live
        if recorded:
            from pmwvc_analysis.recording.reader import read_session
            from pmwvc_analysis.transparency.measured import measure, pattern

            traces = read_session(folder)
            live = live or traces.source == "live"
            by_name = {user.name: user for user in traces.users}
            name = scenario.users[place].name
            if name not in by_name:
                raise PmwvcError(f"{folder}: no trace of {name} was recorded")
            measured = measure(by_name[name], scenario.users[place])
            forces = pattern(traces.users, scenario, place)
        found = transparency(scenario, user=place, live=live)
        if measured is not None:
            if forces != pressing(scenario, place):
                found.notes.append(
                    "Measured and modelled beside it: with the forces of the session, per N of "
                    f"{scenario.users[place].name}: {', '.join(f'{f:.3g}' for f in forces)}."
                )
            exact = build(scenario, live=live)
            model = response(exact, measured.frequency_hz, user=place, forces=forces)
        result = answer(scenario.name, found, measured, model)
        for line in sentences(result):
            print(line)
        if arguments.out:
            _write(Path(arguments.out), found, measured, scenario, result, live=live)
        write(result)
    return 0


def _scenario_of(arguments: argparse.Namespace, folder: Path | None) -> Scenario:
    """Return the scenario asked about, or the one a session was recorded with."""
    if folder is None:
        return files.load(
            arguments.scenario, settings_texts=arguments.settings, users=arguments.users
        )
    if not (folder / "scenario.yaml").is_file():
        raise PmwvcError(f"{folder}: there is no scenario.yaml; is it a session folder?")
    return files.load(
        str(folder / "scenario.yaml"), settings_texts=arguments.settings, users=arguments.users
    )


def _place(scenario: Scenario, name: str | None) -> int:
    names = [user.name for user in scenario.users]
    if name is None:
        return 0
    if name not in names:
        raise PmwvcError(f"--user {name}: there is no such user; there are {', '.join(names)}")
    return names.index(name)


def _write(
    folder: Path, found: Any, measured: Any, scenario: Scenario, result: Any, *, live: bool
) -> None:
    from pmwvc_analysis.figures import transparency_figure
    from pmwvc_analysis.transparency.answer import NAME, arrays_of, write_arrays

    paths = write_arrays(folder, arrays_of(found, measured))
    figure = transparency_figure.draw(found, measured, scenario, live=live)
    paths += transparency_figure.save(figure, folder, NAME)
    text = json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False)
    (folder / f"{NAME}.json").write_text(text + "\n", encoding="utf-8")
    print(f"written: {folder} ({', '.join(path.name for path in paths)}, {NAME}.json)")
