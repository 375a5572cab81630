# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands around a session: the machine, scenarios, links, access."""

import argparse
import os
import sys
import textwrap
from dataclasses import asdict
from typing import Any

from pmwvc_bringup import command as cli
from pmwvc_core.errors import PmwvcError


@cli.command(cli.FOLDER.but(nargs="?"), cli.JSON.but("print the findings as JSON on stdout"))
def doctor(arguments: argparse.Namespace) -> cli.Result:
    """Check this machine or a recorded session.

    examples:
      pmwvc doctor                                 this machine
      pmwvc doctor sessions/20260101T120000Z-carry_16ms    a recorded session

    exit code: 1 when the machine has a problem; a recording gives 0 when it is complete, 2 when it
    has only losses that it declares, 3 when it is damaged
    """
    from pmwvc_analysis.doctor import PROBLEM, check_recording, exit_code

    if arguments.folder:
        if not arguments.folder.exists():
            raise PmwvcError(f"{arguments.folder}: there is no such session folder")
        findings = check_recording(arguments.folder)
        code = exit_code(findings)
    else:
        from pmwvc_bringup.machine import examine

        findings = examine()
        code = int(any(finding.status == PROBLEM for finding in findings))
    for finding in findings:
        print(finding.line())
    listed = [asdict(finding) for finding in findings]
    return cli.Result(code, {"exit_code": code, "findings": listed})


WIDTH = 99
LISTED = ("name", "description", "controller", "users", "dof", "duration_s")


@cli.command(cli.SCENARIO.but(name="name", nargs="?", metavar="NAME"), cli.JSON)
def scenarios(arguments: argparse.Namespace) -> cli.Result:
    """List the scenarios, or print one.

    examples:
      pmwvc scenarios                              names and descriptions
      pmwvc scenarios carry_16ms                   every parameter of one, as YAML
      pmwvc scenarios carry_16ms > my.yaml         the start of one of your own
      pmwvc scenarios --json                       the list for a program
    """
    from pmwvc_bringup import scenarios as files
    from pmwvc_core.network.presets import PRESETS

    if arguments.name:
        scenario = files.load(arguments.name)
        sys.stdout.write(files.to_yaml(scenario))
        return cli.Result(document=scenario.to_dict())
    known = [files.load(name).flat() for name in files.known()]
    entries = [(values["name"], values["description"]) for values in known]
    networks = "for --set link.preset=NAME: " + ", ".join(PRESETS) + "."
    for name, text in [*entries, ("", ""), ("networks", networks)]:
        head = f"{name:24} "
        print(textwrap.fill(text, WIDTH, initial_indent=head, subsequent_indent=" " * len(head)))
    listed = [{name: values[name] for name in LISTED} for values in known]
    return cli.Result(document={"scenarios": listed, "networks": list(PRESETS)})


@cli.command(
    cli.argument("folder", "for the files, new or without them", type=cli.path),
    cli.argument("users", "name of a user (its namespace)", nargs="+", metavar="USER"),
)
def token(arguments: argparse.Namespace) -> cli.Result:
    """Make the session tokens of a server and its users.

    examples:
      pmwvc token keys user1 user2               keys/server for the server, keys/user1, keys/user2
      pmwvc node server --ros-args -p session.token_file:=keys/server
      pmwvc node master --ros-args -r __ns:=/user1 -p session.token_file:=keys/user1
    """
    from pmwvc_core.runtime.token_files import write_session

    for path in write_session(arguments.folder, arguments.users):
        print(path)
    return cli.Result()


@cli.command(*cli.GIVEN, cli.JSON)
def links(arguments: argparse.Namespace) -> cli.Result:
    """Show the links of a scenario, with the effects of each.

    examples:
      pmwvc links carry_16ms --set link.preset=wifi_bad
      pmwvc links carry_16ms --set user2.link.up.loss=0.1 --json

    Keys of --json: links, each with name, mean_delay_s, does.
    """
    from pmwvc_core.network.effects import amounts, check, mean_s

    scenario = cli.scenario_of(arguments)
    found: list[dict[str, Any]] = []
    for user, way in ((user, way) for user in scenario.users for way in ("up", "down")):
        params = getattr(user, f"link_{way}")
        check(params)
        does = [f"{1e3 * mean_s(params):.4g} ms on the mean", *amounts(params).values()]
        name = f"{user.name}/{way}"
        found.append({"name": name, "mean_delay_s": mean_s(params), "does": does})
        print(f"{name}: {', '.join(does)}")
    return cli.Result(document={"links": found})


@cli.command(
    cli.argument("action", "check: open one", nargs="?", choices=("check",), metavar="check"),
    cli.argument("name", "kind of device", nargs="?", metavar="NAME"), cli.JSON,
    cli.SET.but("change a parameter of the master, as device.axes; may be repeated"),
    cli.argument("--force", "push the hand with so many N", type=float, default=0.0, metavar="N"),
)  # fmt: skip
def devices(arguments: argparse.Namespace) -> cli.Result:
    """List the kinds of haptic device, or check one before a hand is on it.

    examples:
      pmwvc devices                                what is there, what is missing, how to get it
      pmwvc devices check haply                    rate, age, noise, signs, units; without a force
      pmwvc devices check touch --set dof=3 --force 0.2      and a push of 0.2 N along each axis

    exit code of check: 1 when something is not as it should be
    """
    from pmwvc_bringup.scenarios import settings
    from pmwvc_bringup.session.surroundings import LOCALHOST, RANGE, own_environment, require_ros

    require_ros()
    os.environ |= own_environment({RANGE: LOCALHOST, **os.environ})
    values, problems = settings(arguments.settings)
    if problems or bool(arguments.action) != bool(arguments.name):
        raise PmwvcError("; ".join(problems) or "which device? pmwvc devices lists them")
    from pmwvc_master.devices import check

    wanted, found = {"device.plugin": arguments.name, **values}, []
    lines = check.check_device(wanted, arguments.force) if arguments.name else check.listed()
    for line in lines:
        print(f"{'ok' if line.right else '--'}  {line.text}", flush=True)
        found.append(line._asdict())
    wrong = bool(arguments.name) and not all(line["right"] for line in found)
    return cli.Result(int(wrong), {"lines": found})
