# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc filter``: the velocity filter of a scenario, designed and judged.

Heavy imports stand inside, as in :mod:`pmwvc_bringup.commands`.
"""

import argparse
import json
from pathlib import Path
from typing import Any

from pmwvc_bringup import scenarios as files
from pmwvc_bringup.options import add_json, add_scenario, add_settings
from pmwvc_bringup.output import document
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.scenario import Scenario

EXAMPLES = """\
examples:
  pmwvc filter wall_filtered
  pmwvc filter wall_filtered --set master.velocity_filter.order=3 --out /tmp/filter
  pmwvc filter wall --set master.velocity_filter.kind=exact \\
      --set master.velocity_filter.order=1 --set master.velocity_filter.alpha=0.929

Without alpha and cutoff_hz the filter is designed for the anti-aliasing filter: order 1 by minimax
(App. D), order 2 and more by the lowest cut-off for any environment. Refused where there is none.

Keys of --json: scenario, user, kind, order, share, alpha, cutoff_hz, designed, in_phase_margin,
in_phase_worst_hz, any_environment_margin, any_environment_worst_hz (Hz), switching_gain (at most 1
is passive whatever happens), port_margin (of b; null but for the equivalent form), noise_gain
(rms), flags (conditions not met: in_phase, any_environment, switching, port). --out writes
filter.png, .svg and .json.
"""
NAME = "filter"


def add(several: Any) -> None:
    """Add the command to the sub-commands of a parser."""
    text = "design and check the velocity filter of a scenario"
    parser = several.add_parser("filter", help=text, description=f"{text}.", epilog=EXAMPLES)
    parser.set_defaults(command=run)
    add_scenario(parser)
    add_settings(parser)
    parser.add_argument("--out", metavar="FOLDER", help="folder for figure and numbers")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Answer for the first user."""
    scenario = files.load(
        arguments.scenario, settings_texts=arguments.settings, users=arguments.users
    )
    from pmwvc_analysis.filters.velocity_filter import answer, judge, sentences

    with document(wanted=arguments.json) as write:
        found = judge(scenario)
        result = answer(scenario, found)
        for line in sentences(result):
            print(line)
        if arguments.out:
            folder = Path(arguments.out)
            try:
                names = _written(folder, scenario, found, result)
            except OSError as error:
                raise PmwvcError(f"cannot write into {folder}: {error.strerror}") from error
            print(f"written: {folder} ({', '.join(names)})")
        write(result)
    return 0


def _written(folder: Path, scenario: Scenario, found: Any, result: Any) -> list[str]:
    """Write figure and numbers; return the names of the files."""
    from pmwvc_analysis.figures import velocity_filter_figure
    from pmwvc_analysis.figures.transparency_figure import save

    folder.mkdir(parents=True, exist_ok=True)
    paths = save(velocity_filter_figure.draw(found, scenario), folder, NAME)
    text = json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False)
    paths.append(folder / f"{NAME}.json")
    paths[-1].write_text(text + "\n", encoding="utf-8")
    return [path.name for path in paths]
