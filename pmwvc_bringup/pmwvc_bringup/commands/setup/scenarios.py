# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc scenarios``: the list of scenarios and networks, or one scenario in full."""

import argparse
import sys
import textwrap

from pmwvc_bringup import scenarios as files
from pmwvc_bringup.command import Command, Result, argument
from pmwvc_bringup.options import json_document, scenario_names
from pmwvc_core.network.presets import PRESETS

EXAMPLES = """\
examples:
  pmwvc scenarios                              names and descriptions
  pmwvc scenarios carry_16ms                   every parameter of one, as YAML
  pmwvc scenarios carry_16ms > my.yaml         the start of one of your own
  pmwvc scenarios --json                       the list for a program
"""
WIDTH = 99
LISTED = ("name", "description", "controller", "users", "dof", "duration_s")


def run(arguments: argparse.Namespace) -> Result:
    """Print the list, or one scenario as YAML."""
    if arguments.name:
        scenario = files.load(arguments.name)
        sys.stdout.write(files.to_yaml(scenario))
        return Result(document=scenario.to_dict())
    known = [files.load(name).flat() for name in files.known()]
    for values in known:
        print(_entry(values["name"], values["description"]))
    print()
    print(_entry("networks", "for --set link.preset=NAME: " + ", ".join(PRESETS) + "."))
    listed = [{name: values[name] for name in LISTED} for values in known]
    return Result(document={"scenarios": listed, "networks": list(PRESETS)})


def _entry(name: str, text: str) -> str:
    """Return a name and its description, indented."""
    indent = " " * 25
    return textwrap.fill(text, WIDTH, initial_indent=f"{name:24} ", subsequent_indent=indent)


COMMAND = Command(
    name="scenarios",
    help="list the scenarios, or print one",
    examples=EXAMPLES,
    arguments=(
        argument(
            "name",
            nargs="?",
            metavar="NAME",
            help="name, or a YAML file",
            completer=scenario_names,
        ),
        json_document(),
    ),
    run=run,
)
