# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc transparency``: the rendering of a link, from the model and from a recording."""

import argparse
from dataclasses import replace
from pathlib import Path

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import doing, write_answer
from pmwvc_core.errors import PmwvcError

MOST_S = 10.0  # of a session that is simulated


@cli.command(
    *cli.MODEL,
    cli.argument("--user", "user to analyse (default: the first)", metavar="NAME", dest="whose"),
    cli.argument("--axis", "axis to analyse (default: 1, x)", type=int, default=1, metavar="N"),
    cli.OUT.but("folder for figure, curves and numbers"),
    cli.JSON,
)
def transparency_(arguments: argparse.Namespace) -> cli.Result:
    """Tell the stiffness, damping and mass rendered to a user, beside an ideal link.

    examples:
      pmwvc transparency carry_16ms
      pmwvc transparency wall --set master.impedance=80 --json
      pmwvc transparency wall --set operator.kind=chirp --out /tmp/rendered
      pmwvc transparency cube_3d --axis 2
      pmwvc transparency sessions/20260101T120000Z-wall --out /tmp/rendered

    From the exact model; where no linear model holds (tdpa, pspm, stored energy for position
    feedback, friction), measured by a simulated press and swing. Buzz, steps and dropouts of the
    force are those of the session, simulated for 10 s at most. A session folder adds the
    estimate from its recording (operator.kind chirp or a replayed force of one user). --out, of
    the model only, writes transparency.png, .svg, .csv and .json.

    Keys of --json: scenario, user, axis (1: x), source (model or measured), admittance_dc (m/N at
    rest), k_felt (its inverse), b_felt (N s/m, pressing, device included); nothing touched:
    mass_felt (kg) and b_free (N s/m), device included, mass_link and b_link, without it;
    first_peak_hz; ideal (the same eight for direct coupling at every tick, no delay), measured
    (null, or points, trusted, stretches, from_hz, to_hz, coherence_median, error_median), notes,
    felt (buzz_n, force_step_max_n, blows, dropout_s and more: docs/file_format.md, of a user).
    null: no such limit exists, or it is unknown.
    """
    folder = Path(arguments.scenario)
    recorded = folder.is_dir()
    if recorded:
        if not (folder / "scenario.yaml").is_file():
            raise PmwvcError(f"{folder}: there is no scenario.yaml; is it a session folder?")
        arguments.scenario = str(folder / "scenario.yaml")
    scenario = cli.scenario_of(arguments)
    names = [user.name for user in scenario.users]
    whose, axis = arguments.whose or names[0], arguments.axis - 1
    if whose not in names:
        raise PmwvcError(f"--user {whose}: there is no such user; there are {', '.join(names)}")
    if not 0 <= axis < scenario.dof:
        raise PmwvcError(f"--axis {arguments.axis}: must be 1 to {scenario.dof} (dof)")
    if recorded and axis:
        text = "a recording is measured along axis 1; ask the model with"
        raise PmwvcError(f"--axis {arguments.axis}: {text} {arguments.scenario}")
    index = names.index(whose)
    import numpy as np

    from pmwvc_analysis.compare.probes import measured_transparency
    from pmwvc_analysis.models.linear import NonlinearError
    from pmwvc_analysis.models.linearize import build
    from pmwvc_analysis.recording.reader import read_session
    from pmwvc_analysis.traces.felt import felt, felt_words
    from pmwvc_analysis.transparency.answer import answer, sentences
    from pmwvc_analysis.transparency.frequency import response
    from pmwvc_analysis.transparency.measured import measure, require_alone
    from pmwvc_analysis.transparency.pressing import pressing
    from pmwvc_analysis.transparency.transparency import transparency
    from pmwvc_core.simulation.session import simulate_one

    measured, model = None, None
    with doing("computing what is rendered"):
        traces = read_session(folder) if recorded else None
        live = arguments.live or bool(traces and traces.live)
        try:
            found = transparency(scenario, user=index, axis=axis, live=live)
        except NonlinearError as error:
            if arguments.out or axis:
                raise
            found = measured_transparency(scenario, index, error)
        short = replace(scenario, duration_s=min(scenario.duration_s, MOST_S))
        traces = traces or simulate_one(short)
    if (own := {user.name: user for user in traces.users}.get(whose)) is None:
        raise PmwvcError(f"{folder}: no trace of {whose} was recorded")
    if recorded:
        require_alone(scenario, index)
        measured = measure(own, scenario.users[index])
        if found.source == "model":
            if np.count_nonzero(pressing(scenario, index)) > 1:
                found.notes.append(f"Measured and modelled beside it: {whose} pushes alone.")
            model = response(build(scenario, live=live), measured.frequency_hz, user=index)
    result = answer(scenario.name, found, measured, model)
    result["felt"] = felt(traces, own, scenario)._asdict()
    words = f"{whose}, {'recorded' if recorded else 'simulated'}: {felt_words(result['felt'])}"
    print(*sentences(result), words, sep="\n")
    if arguments.out:
        from pmwvc_analysis.figures.model_charts import transparency as chart
        from pmwvc_analysis.transparency.answer import NAME, write

        target, drawn = arguments.out, chart(found, measured, scenario, live=live)
        write_answer(target, NAME, result, drawn, write(target, found, measured))
    return cli.Result(document=result)
