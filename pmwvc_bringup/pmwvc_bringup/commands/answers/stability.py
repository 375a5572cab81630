# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc stability``: the exact model's answer on the stability of a scenario."""

import argparse
import math

from pmwvc_bringup.command import Command, Result, argument
from pmwvc_bringup.options import MODEL, json_document, scenario_of
from pmwvc_bringup.progress import doing
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.scenario import Scenario

EXAMPLES = """\
examples:
  pmwvc stability carry_16ms
  pmwvc stability carry_16ms --set server.coupling=one_frame_late --set link.delay_s=0.024
  pmwvc stability my_scenario.yaml --users 3 --json
  pmwvc stability wall_slow --set server.compensation=corrected --damping 0,5,10

Exact with hands off and all contacts touching.

--damping gives the Z-width: the largest stable contact stiffness for each contact damping. It is
exact where the scenario is linear. Otherwise sessions are simulated, in which a small push has to
die out, and the stiffness is bisected (some 10 s for each damping). Keys of its --json: scenario,
simulated, z_width (damping, stable_up_to, unstable_from: null where nothing was unstable).

Keys of --json: spectral_radius, stable, k_max (N/m, null: none up to k_max_bound is unstable),
k_max_bound, k_max_unknown (why it is not known), islands, rigid_body_modes, states,
hyperframe_ticks, slowest, notes.
"""
HIGHEST = 1e12  # contact stiffness that may be asked for [N/m]


def run(arguments: argparse.Namespace) -> Result:
    """Print spectral radius, largest stable contact stiffness and notes."""
    scenario = scenario_of(arguments)
    from pmwvc_analysis.models.answer import answer, sentences
    from pmwvc_analysis.models.stability import BOUND, LOWEST

    bound = BOUND if arguments.bound is None else arguments.bound
    if not LOWEST < bound <= HIGHEST:
        raise PmwvcError(f"--bound {bound:g}: must be > {LOWEST:g} and <= 1e12 N/m")
    if arguments.damping is not None:
        return _z_width(scenario, arguments)
    with doing("computing the stability"):
        found = answer(scenario, live=arguments.live, bound=bound)
    for line in sentences(found):
        print(line)
    return Result(document=found)


def _z_width(scenario: Scenario, arguments: argparse.Namespace) -> Result:
    """Print the largest stable contact stiffness for each contact damping."""
    from pmwvc_analysis.maps.z_width import HIGHEST_SIMULATED, of_each
    from pmwvc_analysis.models.linear import nonlinear

    elements = nonlinear(scenario)
    how = "from the exact model"
    if elements:
        most = HIGHEST_SIMULATED if arguments.bound is None else arguments.bound
        texts = ", ".join(dict.fromkeys(element.text for element in elements))
        how = f"simulated up to {most:g} N/m, as it is not linear ({texts})"
    print(f"{scenario.name}: largest stable contact stiffness, {how}")
    found = []
    with doing("computing the Z-width") as work:
        for each in of_each(
            scenario, arguments.damping, bound=arguments.bound, live=arguments.live
        ):
            found.append(each)
            work(len(found) / len(arguments.damping))
    for b, (low, high) in found:
        words = f"{low:.0f} N/m" if high is not None else f"none up to {low:g} N/m is unstable"
        print(f"  B = {b:g} N s/m: {words}")
    rows = [{"damping": b, "stable_up_to": low, "unstable_from": high} for b, (low, high) in found]
    document = {"scenario": scenario.name, "simulated": bool(elements), "z_width": rows}
    return Result(document=document)


def _numbers(text: str) -> list[float]:
    """Return the dampings of an option."""
    try:
        found = [float(each) for each in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text}: numbers joined by commas, as 0,5,10") from None
    if any(not 0.0 <= each < math.inf for each in found):
        raise argparse.ArgumentTypeError(f"{text}: contact damping is >= 0 N s/m")
    return found


COMMAND = Command(
    name="stability",
    help="compute stability and the largest stable contact stiffness from the exact model",
    examples=EXAMPLES,
    arguments=(
        *MODEL,
        argument(
            "--bound",
            type=float,
            metavar="K",
            help="largest contact stiffness to search, in N/m (default: 1e6, simulated 20000)",
        ),
        argument(
            "--damping",
            type=_numbers,
            metavar="B,...",
            help="contact dampings in N s/m: the largest stiffness for each (Z-width)",
        ),
        json_document(),
    ),
    run=run,
)
