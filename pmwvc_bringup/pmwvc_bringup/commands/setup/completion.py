# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""``pmwvc completion``: shell completion of commands, options and their values by argcomplete."""

import argparse

from pmwvc_bringup.command import Command, Result, argument

SHELLS = ("bash", "zsh", "fish")
PROGRAMS = ["pmwvc", "./pmwvc"]
EXAMPLES = """\
examples:
  eval "$(./pmwvc completion)"                 this bash
  ./pmwvc completion zsh >> ~/.zshrc           every zsh from now on
"""


def run(arguments: argparse.Namespace) -> Result:
    """Print the script."""
    from argcomplete.shell_integration import shellcode

    print(shellcode(PROGRAMS, shell=arguments.shell))
    return Result()


COMMAND = Command(
    name="completion",
    help="print the completion script for a shell",
    examples=EXAMPLES,
    arguments=(
        argument("shell", nargs="?", choices=SHELLS, default="bash", help="bash by default"),
    ),
    run=run,
)
