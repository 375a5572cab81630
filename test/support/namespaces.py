# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Machines for tests: network namespaces on one switch that passes no multicast.

Each namespace is held by a process that ends with the test; nothing stays behind.
"""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager


class NotAllowed(Exception):
    """Network namespaces cannot be made here; the message says why."""


class Machine:
    """One namespace.

    Parameters
    ----------
    holder
        A process inside it.
    address
        Its address on the switch.
    """

    def __init__(self, holder: subprocess.Popen, address: str) -> None:
        self._holder = holder
        self.address = address
        self.into = ["nsenter", "--target", str(holder.pid), "--net"]
        if os.geteuid():
            self.into += ["--user", "--preserve-credentials"]

    def run(self, *words: str) -> str:
        """Run a command inside; return its output."""
        done = subprocess.run([*self.into, *words], capture_output=True, text=True, check=False)
        if done.returncode:
            raise NotAllowed(f"{' '.join(words)}: {done.stderr.strip()}")
        return done.stdout

    def set_clock_ahead(self, seconds: int) -> float:
        """Let programs see a monotonic clock that is ahead, where the kernel can do that; return
        how far ahead theirs is [s].
        """
        words = ["unshare", "--time", "--monotonic", str(seconds)]
        probe = [*self.into, *words, sys.executable, "-c", "import time; print(time.monotonic())"]
        done = subprocess.run(probe, capture_output=True, text=True, check=False)
        if done.returncode or float(done.stdout) < time.monotonic() + seconds / 2:
            return 0.0
        self.into += words
        return float(seconds)

    @property
    def pid(self) -> int:
        """A process inside."""
        return self._holder.pid


@contextmanager
def machines(addresses: Sequence[str]) -> Iterator[list[Machine]]:
    """Yield machines with these addresses (/24), on a switch of their own.

    Raises
    ------
    NotAllowed
        If this system does not let us.
    """
    if missing := [tool for tool in ("ip", "unshare", "nsenter") if shutil.which(tool) is None]:
        raise NotAllowed(f"{', '.join(missing)}: not installed")
    with ExitStack() as stack:
        switch = Machine(_held(stack, []), "")
        switch.run("ip", "link", "add", "switch", "type", "bridge", "mcast_snooping", "0")
        switch.run("ip", "link", "set", "switch", "up")
        found = []
        for number, address in enumerate(addresses):
            inside = switch.into if os.geteuid() else []
            machine = Machine(_held(stack, inside, nested=bool(inside)), address)
            port = f"port{number}"
            switch.run("ip", "link", "add", port, "type", "veth", "peer", "eth0")
            switch.run("ip", "link", "set", "eth0", "netns", str(machine.pid))
            switch.run("ip", "link", "set", port, "master", "switch", "up")
            switch.run(*f"bridge link set dev {port} mcast_flood off".split())
            machine.run("ip", "address", "add", f"{address}/24", "dev", "eth0")
            machine.run("ip", "link", "set", "eth0", "up")
            machine.run("ip", "link", "set", "lo", "up")
            found.append(machine)
        yield found


def _held(stack: ExitStack, prefix: Sequence[str], *, nested: bool = False) -> subprocess.Popen:
    """Start a process in a new namespace; it ends when the stack closes."""
    own = ["unshare", "--net"]
    if os.geteuid() and not nested:
        own = ["unshare", "--user", "--map-root-user", "--net"]
    script = "echo ready; exec cat"
    words = [*prefix, *own, "sh", "-c", script]
    pipe = subprocess.PIPE
    process = subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=pipe, text=True)
    stack.callback(_end, process)
    assert process.stdout is not None and process.stderr is not None
    if process.stdout.readline() != "ready\n":
        raise NotAllowed(process.stderr.read().strip() or "unshare: no namespace")
    return process


def _end(process: subprocess.Popen) -> None:
    process.kill()
    process.communicate()
