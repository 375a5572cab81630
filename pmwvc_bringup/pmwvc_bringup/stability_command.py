# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc stability``: what the exact model says of a scenario.

Heavy imports stand inside, as in :mod:`pmwvc_bringup.commands`.
"""

import argparse
from typing import Any

from pmwvc_bringup import scenarios as files
from pmwvc_bringup.options import add_json, add_model_options
from pmwvc_bringup.output import document

EXAMPLES = """\
examples:
  pmwvc stability carry_16ms
  pmwvc stability carry_16ms --set server.coupling=one_frame_late --set link.delay_s=0.024
  pmwvc stability my_scenario.yaml --users 3 --json

Exact with hands off and all contacts touching.

Keys of --json: spectral_radius, stable, k_max (N/m, null: none up to k_max_bound is unstable),
k_max_bound, islands, rigid_body_modes, states, hyperframe_ticks, slowest, notes.
"""


def add(several: Any) -> None:
    """Add the command to the sub-commands of a parser."""
    text = "compute stability and the largest stable contact stiffness from the exact model"
    parser = several.add_parser("stability", help=text, description=f"{text}.", epilog=EXAMPLES)
    parser.set_defaults(command=run)
    add_model_options(parser)
    parser.add_argument(
        "--bound",
        type=float,
        default=1e6,
        metavar="K",
        help="largest contact stiffness to search, in N/m (default: 1e6)",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Answer."""
    scenario = files.load(
        arguments.scenario, settings_texts=arguments.settings, users=arguments.users
    )
    from pmwvc_analysis.models.answer import answer, sentences
    from pmwvc_analysis.models.stability import LOWEST
    from pmwvc_core.errors import PmwvcError

    if not LOWEST < arguments.bound <= 1e12:
        raise PmwvcError(f"--bound {arguments.bound:g}: must be > {LOWEST:g} and <= 1e12 N/m")
    with document(wanted=arguments.json) as write:
        found = answer(scenario, live=arguments.live, bound=arguments.bound)
        for line in sentences(found):
            print(line)
        write(found)
    return 0
