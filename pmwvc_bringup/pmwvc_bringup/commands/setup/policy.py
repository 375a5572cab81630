# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc policy``: the SROS2 policy of a session, for an installed ROS 2."""

import argparse
from pathlib import Path

from pmwvc_bringup.command import Command, Result, argument
from pmwvc_core.errors import ParameterError

EXAMPLES = """\
examples:
  pmwvc policy user1 user2 --out policy.xml
  ros2 security create_permission keystore /pmwvc/user1 policy.xml
"""


def run(arguments: argparse.Namespace) -> Result:
    """Print the policy, or write it into a file."""
    from pmwvc_bringup.session.policy import policy

    users = arguments.users
    if not all(name.isidentifier() for name in users) or len(set(users)) != len(users):
        raise ParameterError(
            f"users = {', '.join(users)}: must be different names of letters, digits and '_'"
        )
    text = policy(users)
    if arguments.out is None:
        print(text, end="")
        return Result()
    try:
        Path(arguments.out).expanduser().write_text(text, encoding="utf-8")
    except OSError as error:
        raise ParameterError(f"{arguments.out}: {error.strerror or error}") from None
    return Result()


COMMAND = Command(
    name="policy",
    help="print the SROS2 policy of a session",
    examples=EXAMPLES,
    arguments=(
        argument("users", nargs="+", metavar="USER", help="name of a user (its namespace)"),
        argument("--out", metavar="FILE", help="write it there instead"),
    ),
    run=run,
)
