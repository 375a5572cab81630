# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc transparency``: the rendering of a link, from the model and from a recording."""

import argparse
from pathlib import Path

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import doing, write_answer
from pmwvc_core.errors import PmwvcError


@cli.command(
    "transparency",
    "compute the stiffness, damping and mass rendered to a user, beside an ideal link",
    """\
examples:
  pmwvc transparency carry_16ms
  pmwvc transparency wall --set master.impedance=80 --json
  pmwvc transparency wall --set operator.kind=chirp --out /tmp/rendered
  pmwvc transparency cube_3d --axis 2
  pmwvc transparency sessions/20260101T120000Z-wall --out /tmp/rendered

A session folder adds the estimate from its recording (operator.kind chirp, sinusoid or a replayed
force). --out writes transparency.png, .svg, .csv, .npz, .mat and .json.

Keys of --json: scenario, user, axis (1: x), admittance_dc (m/N at rest), k_felt (its inverse),
b_felt (N s/m, pressing, device included), mass_felt (kg, nothing touched, device included),
first_peak_hz, ideal (the same five for direct coupling at every tick, no delay), measured (null,
or points, trusted, stretches, from_hz, to_hz, coherence_median, error_median), notes. null: no
such limit exists.
""",
    *cli.MODEL,
    cli.argument(
        "--user", metavar="NAME", dest="whose", help="user to analyse (default: the first)"
    ),
    cli.argument(
        "--axis", type=int, default=1, metavar="N", help="axis to analyse (default: 1, x)"
    ),
    cli.out("folder for figure, curves and numbers"),
    cli.json_document(),
)
def transparency_(arguments: argparse.Namespace) -> cli.Result:
    """Print what the link renders to one user, and write curves."""
    folder = Path(arguments.scenario)
    recorded = folder.is_dir()
    if recorded:
        if not (folder / "scenario.yaml").is_file():
            raise PmwvcError(f"{folder}: there is no scenario.yaml; is it a session folder?")
        arguments.scenario = str(folder / "scenario.yaml")
    scenario = cli.scenario_of(arguments)
    names, whose = [user.name for user in scenario.users], arguments.whose
    if whose not in (None, *names):
        raise PmwvcError(f"--user {whose}: there is no such user; there are {', '.join(names)}")
    index, axis = names.index(whose) if whose else 0, arguments.axis - 1
    if not 0 <= axis < scenario.dof:
        raise PmwvcError(f"--axis {arguments.axis}: must be 1 to {scenario.dof} (dof)")
    if recorded and axis:
        raise PmwvcError(
            f"--axis {arguments.axis}: a recording is measured along axis 1; ask the model with "
            f"{folder / 'scenario.yaml'}"
        )
    import numpy as np

    from pmwvc_analysis.models.linearize import build
    from pmwvc_analysis.transparency.answer import answer, sentences
    from pmwvc_analysis.transparency.frequency import response
    from pmwvc_analysis.transparency.pressing import pressing
    from pmwvc_analysis.transparency.transparency import transparency

    measured = model = None
    factors: list[float] = []
    live = arguments.live
    if recorded:
        from pmwvc_analysis.recording.reader import read_session
        from pmwvc_analysis.transparency.measured import measure, pattern

        with doing("reading the recording"):
            traces = read_session(folder)
        live = live or traces.live
        by_name = {user.name: user for user in traces.users}
        if names[index] not in by_name:
            raise PmwvcError(f"{folder}: no trace of {names[index]} was recorded")
        measured = measure(by_name[names[index]], scenario.users[index])
        factors = pattern(traces.users, scenario, index)
    with doing("computing what is rendered"):
        found = transparency(scenario, user=index, axis=axis, live=live)
    if measured is not None:
        steady = pressing(scenario, index)
        forces = np.zeros_like(steady)
        forces[:, 0] = factors
        if not np.array_equal(forces, steady):
            found.notes.append(
                "Measured and modelled beside it: with the forces of the session, per N of "
                f"{names[index]}: {', '.join(f'{f:.3g}' for f in factors)}."
            )
        exact = build(scenario, live=live)
        model = response(exact, measured.frequency_hz, user=index, forces=forces)
    result = answer(scenario.name, found, measured, model)
    for line in sentences(result):
        print(line)
    if arguments.out:
        from pmwvc_analysis.figures.model_charts import transparency as chart
        from pmwvc_analysis.transparency.answer import NAME, write

        out_folder = Path(arguments.out)
        paths = write(out_folder, found, measured)
        drawn = chart(found, measured, scenario, live=live)
        write_answer(out_folder, NAME, result, drawn, paths)
    return cli.Result(document=result)
