# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line as a program: an interrupt at any instant ends it with one line and code 130.

The launcher starts Python with SIGINT blocked, so that an interrupt during Python's own start
waits for the handler here. While the modules of the commands load, nothing is there to clean up;
afterwards an interrupt is a ``KeyboardInterrupt``, and one that reaches the top or gets lost in a
destructor ends the program too. A compiled module that is interrupted while a command loads it
raises an ``ImportError`` in its place.
"""

import os
import signal
import sys
from types import FrameType, TracebackType
from typing import NoReturn

from pmwvc_bringup import INTERRUPTS

INTERRUPTED = 130
LINE = b"pmwvc: interrupted\n"


def _end() -> NoReturn:
    os.write(2, LINE)
    os._exit(INTERRUPTED)


def _while_running(number: int, _: FrameType | None) -> None:
    INTERRUPTS.append(number)
    raise KeyboardInterrupt


def _uncaught(
    kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    if issubclass(kind, KeyboardInterrupt) or (INTERRUPTS and issubclass(kind, ImportError)):
        _end()
    sys.__excepthook__(kind, error, trace)


def _unraisable(lost: "sys.UnraisableHookArgs") -> None:
    if issubclass(lost.exc_type, KeyboardInterrupt):
        _end()
    sys.__unraisablehook__(lost)


def main() -> int:
    """Run the command line and return its exit code."""
    # Matrices are small here: threads of the linear algebra would make them four times slower.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    ignored = signal.getsignal(signal.SIGINT) == signal.SIG_IGN  # by nohup, or a background job
    if not ignored:
        signal.signal(signal.SIGINT, lambda *_: _end())
    if hasattr(signal, "pthread_sigmask"):  # not on Windows
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    sys.excepthook, sys.unraisablehook = _uncaught, _unraisable
    from pmwvc_bringup import cli

    cli.library()
    if not ignored:
        signal.signal(signal.SIGINT, _while_running)
    code = cli.main()
    if code == INTERRUPTED:  # Python ends by the signal itself where exec() was interrupted
        sys.stdout.flush()
        os._exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
