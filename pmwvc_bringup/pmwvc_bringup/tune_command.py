# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc tune``: impedance, filter and hold for a link and an environment.

Heavy imports stand inside, as in :mod:`pmwvc_bringup.commands`.
"""

import argparse
from pathlib import Path
from typing import Any

from pmwvc_bringup import scenarios as files
from pmwvc_bringup.options import add_json, add_model_options
from pmwvc_bringup.output import document
from pmwvc_core.errors import PmwvcError

EXAMPLES = """\
examples:
  pmwvc tune carry_16ms
  pmwvc tune wall --set link.delay_s=0.03 --set server.contact_stiffness=500
  pmwvc tune carry_24ms --live --json
  pmwvc tune carry_24ms --out tuned.yaml && pmwvc simulate tuned.yaml

Criteria: margin (proved at any delay, spectral radius, largest stiffness, aliasing gain), felt
stiffness and mass beside the ideal, noise that an encoder's steps (device.encoder_step_m, or
10 um) make of the force. What is not linear is left out of the exact model, which is said. Keys of
--json: scenario, not_linear, bounds, best, others, costs; see docs/tuning.md.
"""


def add(several: Any) -> None:
    """Add the command to the sub-commands of a parser."""
    text = "propose impedance, filter and hold for a link and an environment"
    parser = several.add_parser("tune", help=text, description=f"{text}.", epilog=EXAMPLES)
    parser.set_defaults(command=run)
    add_model_options(parser)
    parser.add_argument(
        "--out", metavar="FILE", help="YAML file for the scenario with the proposal"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Propose."""
    scenario = files.load(
        arguments.scenario, settings_texts=arguments.settings, users=arguments.users
    )
    from pmwvc_analysis.tune.search import propose
    from pmwvc_analysis.tune.words import answer, sentences

    path = _target(arguments.out) if arguments.out else None
    with document(wanted=arguments.json) as write:
        found = propose(scenario, live=arguments.live)
        for line in sentences(scenario, found):
            print(line)
        if path is not None:
            path.write_text(files.to_yaml(found.best.choice.applied(scenario)), "utf-8")
            print(f"written: {path}")
        write(answer(scenario, found))
    return 0


def _target(text: str) -> Path:
    """Return the file to write; refused before anything is computed.

    Raises
    ------
    PmwvcError
        If it is no YAML file, is there already, or has no folder to be in.
    """
    path = Path(text)
    if path.suffix not in files.SUFFIXES:
        raise PmwvcError(f"--out {text}: must end in {' or '.join(files.SUFFIXES)}")
    if path.exists():
        raise PmwvcError(f"--out {text}: is there already; give another name")
    if not path.parent.is_dir():
        raise PmwvcError(f"--out {text}: there is no folder {path.parent}")
    return path
