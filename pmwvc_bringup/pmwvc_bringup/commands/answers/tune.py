# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc tune``: impedance, filter and hold for a link and an environment."""

import argparse
from dataclasses import replace
from pathlib import Path

from pmwvc_bringup import scenarios as files
from pmwvc_bringup.command import Command, Result
from pmwvc_bringup.options import MODEL, json_document, out, scenario_of
from pmwvc_bringup.progress import doing
from pmwvc_core.errors import PmwvcError

EXAMPLES = """\
examples:
  pmwvc tune carry_16ms
  pmwvc tune wall --set link.delay_s=0.03 --set server.contact_stiffness=500
  pmwvc tune carry_24ms --live --json
  pmwvc tune carry_24ms --out tuned.yaml && pmwvc simulate tuned.yaml

Criteria: margin (proved at any delay, spectral radius, largest stiffness, aliasing gain), rendered
stiffness and mass beside the ideal, force noise by encoder steps (device.encoder_step_m, or
10 um). Nonlinear elements are left out of the exact model and named. Keys of --json: scenario,
not_linear, bounds, best, others, costs; see docs/tuning.md.
"""


def run(arguments: argparse.Namespace) -> Result:
    """Print the proposal, and write the scenario with it."""
    scenario = scenario_of(arguments)
    from pmwvc_analysis.tune.search import propose
    from pmwvc_analysis.tune.words import answer, sentences

    path = _target(arguments.out) if arguments.out else None
    with doing("searching for the best impedance, filter and hold"):
        found = propose(scenario, live=arguments.live)
    for line in sentences(scenario, found):
        print(line)
    if path is not None:
        tuned = found.best.choice.applied(scenario)
        text = f"{scenario.name} as tuned: {scenario.description}"
        path.write_text(files.to_yaml(replace(tuned, name=path.stem, description=text)), "utf-8")
        print(f"written: {path}")
    return Result(document=answer(scenario, found))


def _target(text: str) -> Path:
    """Return the file to write; PmwvcError, before anything is computed, where it cannot be."""
    path = Path(text)
    if path.suffix not in files.SUFFIXES:
        raise PmwvcError(f"--out {text}: must end in {' or '.join(files.SUFFIXES)}")
    if path.exists():
        raise PmwvcError(f"--out {text}: is there already; give another name")
    if not path.parent.is_dir():
        raise PmwvcError(f"--out {text}: there is no folder {path.parent}")
    return path


COMMAND = Command(
    name="tune",
    help="propose impedance, filter and hold for a link and an environment",
    examples=EXAMPLES,
    arguments=(
        *MODEL,
        out("YAML file for the scenario with the proposal", metavar="FILE"),
        json_document(),
    ),
    run=run,
)
