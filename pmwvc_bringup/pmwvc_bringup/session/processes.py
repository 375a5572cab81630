# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Child processes of a session: started, watched, ended. Knows nothing of ROS.

Every child gets a session of its own, so that Ctrl-C in a terminal reaches only the runner, which
ends its children in order. When the runner itself dies, the kernel ends them.
"""

import contextlib
import signal
import subprocess
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

# Signal and time to end after it [s]: a recorder finishes its file on SIGINT. A node gives its
# services and ROS 5 s each before it ends by itself: not to be killed just then.
STOP_SIGNALS = ((signal.SIGINT, 15.0), (signal.SIGTERM, 2.0), (signal.SIGKILL, 5.0))
# Before a command: SIGINT ends it, also where a shell started all this in the background; and when
# the process that started it is gone the kernel ends it by SIGTERM: a master lets go of its
# device, a recorder finishes its file.
ENDS_WITH_PARENT = "env --default-signal=INT setpriv --pdeathsig TERM"


@dataclass
class Child:
    """One running or ended process and its log; as a text, how it ended."""

    name: str
    process: subprocess.Popen[bytes]
    log: Path
    reported: bool = field(default=False, init=False)

    @property
    def running(self) -> bool:
        """Tell whether the process is still there."""
        return self.process.poll() is None

    @property
    def code(self) -> int:
        """Exit code of a process that has ended; of one ended by a signal, less than 0."""
        return self.process.returncode

    @property
    def signal(self) -> str | None:
        """Return the name of the signal that ended it, or None."""
        if self.code >= 0:
            return None
        try:
            return signal.Signals(-self.code).name
        except ValueError:
            return f"signal {-self.code}"

    def __str__(self) -> str:
        """Return its end as a clause for people."""
        how = f"was ended by {self.signal}" if self.signal else f"exited with {self.code}"
        return f"{self.name} {how}"

    def has_logged(self, word: str) -> bool:
        """Tell whether a line of its log is this word, or begins or ends with it."""
        lines = map(str.split, self.log_tail(lines=1000).splitlines())
        return any(word in (*line[:1], *line[-1:]) for line in lines)

    def log_tail(self, lines: int = 12) -> str:
        """Return the last lines of its log."""
        try:
            text = self.log.read_text("utf-8", errors="replace")
        except OSError:
            return ""
        return "\n".join(text.rstrip().splitlines()[-lines:])


class Children:
    """The processes of one session, in the order they were started."""

    def __init__(self) -> None:
        self.children: dict[str, Child] = {}

    def start(
        self, name: str, command: Sequence[str], *, env: Mapping[str, str], log: Path
    ) -> Child:
        """Start a process; its output goes to ``log``. Must be called from a thread that lives as
        long as the session: the kernel ties the child to the thread that forked it.
        """
        log.parent.mkdir(parents=True, exist_ok=True)
        with log.open("wb") as output:
            process = subprocess.Popen(
                [*ENDS_WITH_PARENT.split(), *command],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env=env,
                start_new_session=True,
            )
        self.children[name] = child = Child(name, process, log)
        return child

    def endings(self) -> list[Child]:
        """Return the processes that ended since the last call."""
        found = [one for one in self.children.values() if not (one.running or one.reported)]
        for child in found:
            child.reported = True
        return found

    def running(self) -> list[str]:
        """Return the names of the processes still there."""
        return [child.name for child in self.children.values() if child.running]

    def stop(
        self, names: Iterable[str], *, hurried: Callable[[], bool] = lambda: False
    ) -> list[Child]:
        """End processes together: SIGINT, then SIGTERM, then SIGKILL, each with a time to end.

        ``hurried`` cuts these times short (a second Ctrl-C). Returns those that did not exit
        cleanly.
        """
        chosen = [self.children[name] for name in names if name in self.children]
        for child in chosen:
            _send(child, signal.SIGCONT)  # one that was stopped (SIGSTOP) can end
        for number, timeout_s in STOP_SIGNALS:
            for child in chosen:
                _send(child, number)
            if _await(chosen, timeout_s, hurried if number != signal.SIGKILL else lambda: False):
                break
        found = [one for one in chosen if one.process.poll() and not one.reported]
        for child in chosen:
            child.reported = True
        return found

    def kill(self) -> None:
        """End everything that is left, at once."""
        for child in self.children.values():
            _send(child, signal.SIGKILL)
        _await(list(self.children.values()), 5.0, lambda: False)


def _send(child: Child, number: signal.Signals) -> None:
    if child.running:
        with contextlib.suppress(ProcessLookupError):
            child.process.send_signal(number)


def _await(children: Sequence[Child], timeout_s: float, hurried: Callable[[], bool]) -> bool:
    """Wait until all have ended; return whether they have."""
    until = time.monotonic() + timeout_s
    while any(child.running for child in children):
        if time.monotonic() > until or hurried():
            return False
        time.sleep(0.01)
    return True
