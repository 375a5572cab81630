# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc filter``: the velocity filter of a scenario, designed and judged."""

import argparse
from pathlib import Path

from pmwvc_bringup.command import Command, Result
from pmwvc_bringup.options import SCENARIO, USERS, json_document, out, scenario_of, settings
from pmwvc_bringup.output import write_answer

EXAMPLES = """\
examples:
  pmwvc filter wall_filtered
  pmwvc filter wall_filtered --set master.velocity_filter.order=3 --out /tmp/filter
  pmwvc filter wall --set master.velocity_filter.kind=exact \\
      --set master.velocity_filter.order=1 --set master.velocity_filter.alpha=0.929

Without alpha and cutoff_hz the filter is designed for the anti-aliasing filter: order 1 by minimax
(App. D), order 2 and more by the lowest cut-off for any environment. Refused where none exists.

Keys of --json: scenario, user, kind, order, share, alpha, cutoff_hz, designed, in_phase_margin,
in_phase_worst_hz, any_environment_margin, any_environment_worst_hz (Hz), switching_gain (at most 1
is passive under any switching), port_margin (of b; null but for the equivalent form), noise_gain
(rms), flags (conditions not met: in_phase, any_environment, switching, port). --out writes
filter.png, .svg and .json.
"""


def run(arguments: argparse.Namespace) -> Result:
    """Judge the filter of the first user."""
    scenario = scenario_of(arguments)
    from pmwvc_analysis.filters.velocity_filter import answer, judge, sentences

    found = judge(scenario)
    result = answer(scenario, found)
    for line in sentences(result):
        print(line)
    if arguments.out:
        from pmwvc_analysis.figures.model_charts import velocity_filter

        write_answer(Path(arguments.out), "filter", result, velocity_filter(found, scenario))
    return Result(document=result)


COMMAND = Command(
    name="filter",
    help="design and check the velocity filter of a scenario",
    examples=EXAMPLES,
    arguments=(SCENARIO, USERS, settings(), out("folder for figure and numbers"), json_document()),
    run=run,
)
