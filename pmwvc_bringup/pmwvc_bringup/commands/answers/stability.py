# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc stability``: the exact model's answer on the stability of a scenario."""

import argparse

from pmwvc_bringup.command import Command, Result, argument
from pmwvc_bringup.options import MODEL, json_document, scenario_of
from pmwvc_bringup.progress import doing
from pmwvc_core.errors import PmwvcError

EXAMPLES = """\
examples:
  pmwvc stability carry_16ms
  pmwvc stability carry_16ms --set server.coupling=one_frame_late --set link.delay_s=0.024
  pmwvc stability my_scenario.yaml --users 3 --json

Exact with hands off and all contacts touching.

Keys of --json: spectral_radius, stable, k_max (N/m, null: none up to k_max_bound is unstable),
k_max_bound, k_max_unknown (why it is not known), islands, rigid_body_modes, states,
hyperframe_ticks, slowest, notes.
"""
HIGHEST = 1e12  # contact stiffness that may be asked for [N/m]


def run(arguments: argparse.Namespace) -> Result:
    """Print spectral radius, largest stable contact stiffness and notes."""
    scenario = scenario_of(arguments)
    from pmwvc_analysis.models.answer import answer, sentences
    from pmwvc_analysis.models.stability import LOWEST

    if not LOWEST < arguments.bound <= HIGHEST:
        raise PmwvcError(f"--bound {arguments.bound:g}: must be > {LOWEST:g} and <= 1e12 N/m")
    with doing("computing the stability"):
        found = answer(scenario, live=arguments.live, bound=arguments.bound)
    for line in sentences(found):
        print(line)
    return Result(document=found)


COMMAND = Command(
    name="stability",
    help="compute stability and the largest stable contact stiffness from the exact model",
    examples=EXAMPLES,
    arguments=(
        *MODEL,
        argument(
            "--bound",
            type=float,
            default=1e6,
            metavar="K",
            help="largest contact stiffness to search, in N/m (default: 1e6)",
        ),
        json_document(),
    ),
    run=run,
)
