# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc compare``: one scenario over several parameters, everything else the same."""

import argparse

from pmwvc_bringup.command import Result, argument, command
from pmwvc_bringup.options import (
    NO_FIGURES,
    SCENARIO,
    USERS,
    duration,
    json_document,
    out,
    settings,
)
from pmwvc_bringup.output import terminal
from pmwvc_bringup.progress import doing
from pmwvc_core.plural import count


@command(
    "compare",
    "run a scenario with several parameter values and compare the results",
    """\
examples:
  pmwvc compare carry_16ms --over server.coupling=implicit,one_step_delay \\
                           --over link.delay_s=0,0.016,0.024
  pmwvc compare carry_16ms --controllers pmwvc,direct --duration 8
  pmwvc compare wall_slow --controllers direct,waves,printed,corrected,ledger
  pmwvc compare stiff_24ms --over master.impedance=15,25,40 --live --out /tmp/impedances

--controllers takes pmwvc (the scenario's own settings), direct, virtual_coupling, tdpa, pspm, and
waves (plain), or features on plain waves, joined by +: printed, corrected, ledger (compensation of
a black-box environment decoded late), secant (ledger behind a learned slope), velocity_filter,
velocity_filter_printed, filter_bank, complementary_bank, position, position_printed,
position_integral. Controllers that a scenario does not allow are left out
with a note.

Every combination of the values runs with the same hands and the same fate of every packet (one
seed), in virtual time or, with --live, as nodes one session after the other. virtual_coupling,
tdpa and pspm are tuned by search for each combination, unless baseline.NAME.* is set: 120 settings
are simulated for up to 20 s, which takes about 5 s of computing with two users; the best are kept.
""",
    SCENARIO,
    USERS,
    argument(
        "--over",
        action="append",
        default=[],
        metavar="NAME=A,B,...",
        help="values of a parameter; may be repeated",
    ),
    argument("--controllers", metavar="A,B,...", help="controllers by name; see below"),
    duration("each session"),
    settings("a parameter of all"),
    argument("--live", action="store_true", help="real nodes instead of virtual time"),
    out("new or empty folder (default: sessions/<UTC time>-<scenario>-compare)"),
    NO_FIGURES,
    json_document("print comparison.json on stdout and nothing else"),
)
def compare(arguments: argparse.Namespace) -> Result:
    """Run every combination, record each, and report all of them together."""
    from pmwvc_bringup.comparison.combinations import combinations, fitting, variants_of
    from pmwvc_bringup.session.surroundings import new_folder

    variants, left_out = fitting(
        arguments.scenario, variants_of(arguments.controllers), arguments.settings
    )
    notes = [f"Left out: {variant}: {reason}." for variant, reason in left_out.items()]
    chosen = combinations(
        arguments.scenario,
        arguments.over,
        controllers=variants,
        settings_texts=arguments.settings,
        users=arguments.users,
        duration_s=arguments.duration,
    )
    name = chosen[0].scenario.name
    folder = new_folder(f"{name}-compare", arguments.out)
    from pmwvc_bringup.comparison import report

    console, figures = terminal(), not arguments.no_figures
    console.print(
        f"{name}: {count(len(chosen), 'session')}, {'live' if arguments.live else 'simulated'}"
    )
    with doing("searching the best parameters of controllers without waves") as work:
        chosen = report.tuned(chosen, work)
    if arguments.live:
        entries = report.live(chosen, folder, console, figures=figures)
    else:
        with doing("running") as work:
            entries = report.simulated(chosen, folder, work)
    return report.report(
        folder,
        f"Comparison of {name}",
        entries,
        console,
        notes=notes,
        figures=figures,
    )
