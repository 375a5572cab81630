# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands that answer from the exact model, before any session."""

import argparse
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import doing
from pmwvc_core.errors import PmwvcError

if TYPE_CHECKING:
    from pmwvc_core.scenario.scenario import Scenario


HIGHEST = 1e12  # contact stiffness that may be asked for [N/m]
MOST_STIFF = "largest contact stiffness to search, in N/m (default: 1e6, simulated 20000)"
DAMPINGS = "contact dampings in N s/m: the largest stiffness for each (Z-width)"


def _numbers(text: str) -> list[float]:
    """Return the dampings of an option."""
    try:
        found = [float(each) for each in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text}: numbers joined by commas, as 0,5,10") from None
    if any(not 0.0 <= each < math.inf for each in found):
        raise argparse.ArgumentTypeError(f"{text}: contact damping is >= 0 N s/m")
    return found


@cli.command(
    *cli.MODEL,
    cli.argument("--bound", MOST_STIFF, type=float, metavar="K"),
    cli.argument("--damping", DAMPINGS, type=_numbers, metavar="B,..."),
    cli.JSON,
)
def stability(arguments: argparse.Namespace) -> cli.Result:
    """Compute stability and the largest stable contact stiffness from the exact model.

    examples:
      pmwvc stability carry_16ms
      pmwvc stability carry_16ms --set server.coupling=one_frame_late --set link.delay_s=0.024
      pmwvc stability my_scenario.yaml --users 3 --json
      pmwvc stability wall_slow --set server.compensation=corrected --damping 0,5,10

    Exact with hands off and all contacts touching.

    --damping gives the Z-width: the largest stable contact stiffness for each contact damping. It
    is exact where the scenario is linear. Otherwise sessions are simulated, in which a small push
    has to die out, and the stiffness is bisected (some 10 s for each damping). Keys of its --json:
    scenario, simulated, z_width (damping, stable_up_to, unstable_from: null where nothing was
    unstable).

    Keys of --json: spectral_radius, stable, k_max (N/m, null: none up to k_max_bound is unstable),
    k_max_bound, k_max_unknown (why it is not known), islands, rigid_body_modes, states,
    hyperframe_ticks, slowest, notes.
    """
    scenario = cli.scenario_of(arguments)
    from pmwvc_analysis.models.answer import answer, sentences
    from pmwvc_analysis.models.stability import BOUND, LOWEST

    bound = BOUND if arguments.bound is None else arguments.bound
    if not LOWEST < bound <= HIGHEST:
        raise PmwvcError(f"--bound {bound:g}: must be > {LOWEST:g} and <= 1e12 N/m")
    if arguments.damping is not None:
        return _z_width(scenario, arguments)
    with doing("computing the stability"):
        found = answer(scenario, live=arguments.live, bound=bound)
    print(*sentences(found), sep="\n")
    return cli.Result(document=found)


def _z_width(scenario: "Scenario", arguments: argparse.Namespace) -> cli.Result:
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
    rows: list[dict[str, Any]] = []
    with doing("computing the Z-width") as work:
        dampings, search = arguments.damping, {"bound": arguments.bound, "live": arguments.live}
        for b, (low, high) in of_each(scenario, dampings, **search):
            rows.append({"damping": b, "stable_up_to": low, "unstable_from": high})
            work(len(rows) / len(dampings))
    for row in rows:
        low, high = row["stable_up_to"], row["unstable_from"]
        words = f"{low:.0f} N/m" if high is not None else f"none up to {low:g} N/m is unstable"
        print(f"  B = {row['damping']:g} N s/m: {words}")
    found = {"scenario": scenario.name, "simulated": bool(elements), "z_width": rows}
    return cli.Result(document=found)


@cli.command(
    *cli.MODEL,
    cli.OUT.but("YAML file for the scenario with the proposal", metavar="FILE"),
    cli.JSON,
)
def tune(arguments: argparse.Namespace) -> cli.Result:
    """Propose impedance, filter and hold for a link and an environment.

    examples:
      pmwvc tune carry_16ms
      pmwvc tune wall --set link.delay_s=0.03 --set server.contact_stiffness=500
      pmwvc tune carry_24ms --live --json
      pmwvc tune carry_24ms --out tuned.yaml && pmwvc simulate tuned.yaml

    Criteria: margin (proved at any delay, spectral radius, largest stiffness, aliasing gain),
    rendered stiffness and mass beside the ideal, force noise by encoder steps
    (device.encoder_step_m, or 10 um). Nonlinear elements are left out of the exact model and
    named. Keys of --json: scenario, not_linear, bounds, best, others; see docs/tuning.md.
    """
    scenario = cli.scenario_of(arguments)
    from pmwvc_analysis.tune import words
    from pmwvc_analysis.tune.search import propose
    from pmwvc_bringup.scenarios import SUFFIXES, to_yaml

    path = arguments.out
    if path is not None:  # refused before anything is computed
        for wrong, why in (
            (path.suffix not in SUFFIXES, f"must end in {' or '.join(SUFFIXES)}"),
            (path.exists(), "is there already; give another name"),
            (not path.parent.is_dir(), f"there is no folder {path.parent}"),
        ):
            if wrong:
                raise PmwvcError(f"--out {path}: {why}")
    with doing("searching for the best impedance, filter and hold"):
        found = propose(scenario, live=arguments.live)
        lines = words.sentences(scenario, found)
    print(*lines, sep="\n")
    if path is not None:
        tuned = found.best.choice.applied(scenario)
        text = f"{scenario.name} as tuned: {scenario.description}"
        path.write_text(to_yaml(replace(tuned, name=path.stem, description=text)), "utf-8")
        print(f"written: {path}")
    return cli.Result(document=words.answer(scenario, found))
