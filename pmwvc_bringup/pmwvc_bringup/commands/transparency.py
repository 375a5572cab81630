# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc transparency``: the rendering of a link."""

import argparse

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import doing
from pmwvc_core.errors import PmwvcError, file_errors


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
      pmwvc transparency wall --out /tmp/rendered
      pmwvc transparency cube_3d --axis 2

    From the exact model; where no linear model holds (tdpa, pspm, stored energy for position
    feedback, friction), measured by a simulated press and swing. --out, of the model only, writes
    transparency.png, .svg, .csv and .json.

    Keys of --json: scenario, user, axis (1: x), source (model or measured), admittance_dc (m/N at
    rest), k_felt (its inverse), b_felt (N s/m, pressing, device included); nothing touched:
    mass_felt (kg) and b_free (N s/m), device included; first_peak_hz; ideal (the same six for
    direct coupling at every tick, no delay), notes.
    null: no such limit exists, or it is unknown.
    """
    scenario = cli.scenario_of(arguments)
    names = [user.name for user in scenario.users]
    whose, axis = arguments.whose or names[0], arguments.axis - 1
    if whose not in names:
        raise PmwvcError(f"--user {whose}: there is no such user; there are {', '.join(names)}")
    if not 0 <= axis < scenario.dof:
        raise PmwvcError(f"--axis {arguments.axis}: must be 1 to {scenario.dof} (dof)")
    index = names.index(whose)
    from pmwvc_analysis.compare.probes import measured_transparency
    from pmwvc_analysis.models.linear import NonlinearError
    from pmwvc_analysis.transparency.answer import answer, sentences
    from pmwvc_analysis.transparency.transparency import transparency

    with doing("computing what is rendered"):
        try:
            found = transparency(scenario, user=index, axis=axis, live=arguments.live)
        except NonlinearError as error:
            if arguments.out or axis:
                raise
            found = measured_transparency(scenario, index, error)
    result = answer(scenario.name, found)
    print(*sentences(result), sep="\n")
    if arguments.out:
        from pmwvc_analysis.charts import chart_files
        from pmwvc_analysis.figures.model_charts import transparency as chart
        from pmwvc_analysis.session_files import write_summary
        from pmwvc_analysis.transparency.answer import NAME, write

        with file_errors(f"write into {arguments.out}"):
            paths = [write(arguments.out, found)]
            paths += chart_files.write(chart(found, scenario, live=arguments.live), arguments.out)
            write_summary(arguments.out, result, name=f"{NAME}.json")
        print(*paths, sep="\n")
    return cli.Result(document=result)
