# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc links``: the links of a scenario, each with the tc command of Linux."""

import argparse
from pathlib import Path
from typing import Any

from pmwvc_bringup.command import Result, argument, command
from pmwvc_bringup.options import SCENARIO, USERS, json_document, out, scenario_of, settings
from pmwvc_core.errors import file_errors


@command(
    "links",
    "show the links of a scenario, with the tc command of Linux for each",
    """\
examples:
  pmwvc links carry_16ms --set link.preset=wifi_bad
  pmwvc links carry_16ms --set link.preset=geo --device eth0 --out /tmp/tables
  pmwvc links carry_16ms --set user2.link.up.loss=0.1 --json

For each link: its effects, and the nearest tc command of Linux (netem, as root, on the interface
that sends), with the effects that the command leaves out. Some distributions need a table: --out
writes it; copy it to /usr/lib/tc.

Keys of --json: links, each with name, mean_delay_s, does, tc, not_in_tc, table.
""",
    SCENARIO,
    USERS,
    settings(),
    argument("--device", default="DEV", metavar="DEV", help="network interface to name"),
    out("folder for tables of distributions"),
    json_document(),
)
def links(arguments: argparse.Namespace) -> Result:
    """Print the links of every user."""
    from pmwvc_core.network.effects import amounts, check, mean_s
    from pmwvc_core.network.tc import not_in_tc, table_name, table_text, tc_line

    scenario = scenario_of(arguments)
    found: list[dict[str, Any]] = []
    tables: dict[str, str] = {}
    for user in scenario.users:
        for way, params in (("up", user.link_up), ("down", user.link_down)):
            check(params)
            delay = f"{1e3 * mean_s(params):.4g} ms on the mean"
            found.append(
                {
                    "name": f"{user.name}/{way}",
                    "mean_delay_s": mean_s(params),
                    "does": [delay, *amounts(params).values()],
                    "tc": tc_line(params, device=arguments.device),
                    "not_in_tc": not_in_tc(params),
                    "table": table_name(params),
                }
            )
            if name := table_name(params):
                tables[name] = table_text(params)
    for link in found:
        print(f"{link['name']}: {', '.join(link['does'])}")
        print(f"  {link['tc']}")
        for text in link["not_in_tc"]:
            print(f"  left out: {text}")
    if arguments.out:
        folder, files = Path(arguments.out), {f"{name}.dist": tables[name] for name in tables}
        with file_errors(f"write into {folder}"):
            folder.mkdir(parents=True, exist_ok=True)
            for name, table in files.items():
                (folder / name).write_text(table, "ascii")
        print(f"written: {folder} ({', '.join(files) or 'none needed'})")
    return Result(document={"links": found})
