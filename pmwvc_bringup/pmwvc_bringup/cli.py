# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line ``pmwvc``: one command is parsed and run, and its result becomes the exit code.

Exit code 0: done; 1: a session could not start, the machine has a problem, or ``--check`` found
that a session was not stable, not passive, interrupted, disturbed or not recorded whole; 2: a
mistake of the user, named in one message on stderr; 130: interrupted. (``doctor`` of a recording:
see there.) The commands: :mod:`pmwvc_bringup.commands`.
"""

import os
import sys
from collections.abc import Sequence

from pmwvc_bringup.command import Command
from pmwvc_bringup.output import document
from pmwvc_bringup.parser import build_parser
from pmwvc_core.errors import PmwvcError


def main(words: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    parser = build_parser()
    if "_ARGCOMPLETE" in os.environ:  # a shell asks which words could follow
        import argcomplete

        argcomplete.autocomplete(parser)
    arguments = parser.parse_args(words)
    command: Command = arguments.command
    try:
        with document(wanted=getattr(arguments, "json", False)) as write:
            result = command.run(arguments)
            write(result.document)
        sys.stdout.flush()
        return result.code
    except PmwvcError as error:
        print(f"pmwvc: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # the reader of the output has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("pmwvc: interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
