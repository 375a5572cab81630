# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Windows and macOS as a program of ours meets them: calls and modules that are not there.

``taken_away`` writes a ``sitecustomize`` that a Python started with this folder in its path
obeys. Attributes are gone for everybody, modules for our packages only: the standard
library of Linux needs them.
"""

from pathlib import Path

SCHEDULING = ("sched_getaffinity", "sched_setaffinity", "sched_setscheduler", "sched_param")
SCHEDULING += ("SCHED_FIFO", "SCHED_OTHER", "SCHED_RESET_ON_FORK")
SIGNALS = ("SIGHUP", "SIGKILL", "SIGSTOP", "SIGCONT", "SIGALRM", "SIGUSR1", "SIGUSR2", "SIGQUIT")
MASKS = ("pthread_sigmask", "pthread_kill", "sigwait", "SIG_BLOCK", "SIG_UNBLOCK", "SIG_SETMASK")
USERS = ("geteuid", "getuid", "getloadavg", "getpriority", "setpriority", "PRIO_PROCESS", "nice")
GONE = {
    "Darwin": {"os": SCHEDULING, "signal": (), "time": ()},
    "Windows": {
        "os": (*SCHEDULING, *USERS, "setsid", "killpg", "fchown", "mkfifo"),
        "signal": (*SIGNALS, *MASKS),
        "time": ("CLOCK_MONOTONIC", "clock_gettime", "clock_gettime_ns"),
    },
}
MODULES = {"Darwin": (), "Windows": ("resource", "fcntl", "termios", "pwd", "grp", "pty", "tty")}
ENCODING = {"Darwin": "utf-8", "Windows": "cp1252"}  # of a pipe
PROGRAM = """\
import builtins, ctypes, importlib, platform, warnings
platform.system = lambda: {system!r}
warnings.filterwarnings("error", category=EncodingWarning, module="pmwvc")
for name, attributes in {gone!r}.items():
    for attribute in attributes:
        vars(importlib.import_module(name)).pop(attribute, None)
load, library = builtins.__import__, ctypes.CDLL

def imported(name, space=None, *more, **options):
    if name in {modules!r} and str((space or {{}}).get("__name__")).startswith("pmwvc"):
        raise ModuleNotFoundError(f"No module named {{name!r}}")
    return load(name, space, *more, **options)

def opened(name, *more, **options):
    if name is None and {system!r} == "Windows":
        raise TypeError("argument of type 'NoneType' is not iterable")
    return library(name, *more, **options)

builtins.__import__, ctypes.CDLL = imported, opened
"""


def taken_away(system: str, folder: Path) -> dict[str, str]:
    """Write the program into a new folder; return the environment that makes Python run it."""
    folder.mkdir()
    text = PROGRAM.format(system=system, gone=GONE[system], modules=MODULES[system])
    (folder / "sitecustomize.py").write_text(text, "utf-8")
    return {
        "PYTHONPATH": str(folder),
        "PYTHONIOENCODING": ENCODING[system],
        "PYTHONWARNDEFAULTENCODING": "1",
        "PYTHONUTF8": "0",
    }
