# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands that answer from the exact model, before any session."""

import argparse
from dataclasses import replace

from pmwvc_bringup import command as cli
from pmwvc_bringup.output import doing
from pmwvc_core.errors import PmwvcError


@cli.command(*cli.MODEL, cli.JSON)
def stability(arguments: argparse.Namespace) -> cli.Result:
    """Compute stability and the largest stable contact stiffness from the exact model.

    examples:
      pmwvc stability carry_16ms
      pmwvc stability carry_16ms --set server.coupling=one_frame_late --set link.delay_s=0.024
      pmwvc stability my_scenario.yaml --users 3 --json

    Exact with hands off and all contacts touching.

    Keys of --json: spectral_radius, stable, k_max (N/m, null: none up to k_max_bound is unstable),
    k_max_bound, k_max_unknown (why it is not known), islands, rigid_body_modes, states,
    hyperperiod_ticks, growth_per_s (negative: decays), notes.
    """
    scenario = cli.scenario_of(arguments)
    from pmwvc_analysis.models.answer import answer, sentences

    with doing("computing the stability"):
        found = answer(scenario, live=arguments.live)
        lines = sentences(scenario, live=arguments.live)
    print(*lines, sep="\n")
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

    Criteria: margin (proved at any delay, spectral radius, aliasing gain), rendered stiffness and
    mass beside the ideal, force noise by encoder steps (device.encoder_step_m, or 10 um).
    Nonlinear elements are left out of the exact model and named. Keys of --json: scenario,
    not_linear, bounds, best, others; see docs/tuning.md.
    """
    scenario = cli.scenario_of(arguments)
    from pmwvc_analysis.tune import words
    from pmwvc_analysis.tune.search import propose
    from pmwvc_bringup.scenarios import SUFFIXES, to_yaml

    path = arguments.out
    new = path is None or (path.suffix in SUFFIXES and path.parent.is_dir() and not path.exists())
    if not new:  # refused before anything is computed
        must = f"must be a new file {' or '.join(SUFFIXES)} in a folder that is there"
        raise PmwvcError(f"--out {path}: {must}")
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
