# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc token``: the key of a session and the tokens of its users, as secret files."""

import argparse
from pathlib import Path

from pmwvc_bringup.command import Command, Result, argument

EXAMPLES = """\
examples:
  pmwvc token keys user1 user2                 keys/server for the server, keys/user1, keys/user2
  pmwvc node server --ros-args -p session.token_file:=keys/server
  pmwvc node master --ros-args -r __ns:=/user1 -p session.token_file:=keys/user1
"""


def run(arguments: argparse.Namespace) -> Result:
    """Write the files; none of them may be there."""
    from pmwvc_core.runtime.token_files import write_session

    for path in write_session(Path(arguments.folder).expanduser(), arguments.users):
        print(path)
    return Result()


COMMAND = Command(
    name="token",
    help="make the session tokens of a server and its users",
    examples=EXAMPLES,
    arguments=(
        argument("folder", help="for the files, new or without them"),
        argument("users", nargs="+", metavar="USER", help="name of a user (its namespace)"),
    ),
    run=run,
)
