# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Real nodes for tests: a ROS domain of one's own, and processes that never outlive a test."""

import contextlib
import ctypes
import functools
import io
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import yaml

from pmwvc_bringup.session.surroundings import node_environment
from pmwvc_core.runtime.parameter_values import to_ros_yaml

LONGEST_S = 180.0  # no process of a test lives longer
PATIENCE_S = 100.0  # for an event that has to come
_PR_SET_PDEATHSIG = 1
_RESERVING_PORT = 21_000  # + domain id: bound by whoever uses that domain on this machine
_libc = ctypes.CDLL(None)
_reservations: list[socket.socket] = []


def isolate() -> int:
    """Give this process and its children a ROS domain nobody else uses; return its number.

    Domains 1 to 101 keep DDS off the ephemeral ports. It is reserved while the process lives.
    """
    if not _reservations:
        domain, reservation = _reserve(int(os.environ.get("PYTEST_XDIST_WORKER", "gw0")[2:]))
        _reservations.append(reservation)
        os.environ |= node_environment({}, domain=domain, log_folder=Path(_logs().name))
    return int(os.environ["ROS_DOMAIN_ID"])


@functools.cache
def _logs() -> "tempfile.TemporaryDirectory[str]":
    """Return the folder of the nodes' logs, which is removed when this process ends."""
    return tempfile.TemporaryDirectory(prefix="pmwvc-test-log-", ignore_cleanup_errors=True)


def _reserve(first: int) -> tuple[int, socket.socket]:
    for offset in range(101):
        domain = 1 + (first + offset) % 101
        reservation = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            reservation.bind(("127.0.0.1", _RESERVING_PORT + domain))
        except OSError:
            reservation.close()
        else:
            return domain, reservation
    raise RuntimeError("all ROS domains of this machine are in use")


class Program:
    """A program in a process of its own, which does not outlive the test.

    Parameters
    ----------
    command
        What to run.
    environment, folder
        Its environment and working folder; those of this process by default.
    """

    def __init__(
        self,
        command: Sequence[Any],
        *,
        environment: Mapping[str, str] | None = None,
        folder: Path | None = None,
    ) -> None:
        self.lines: list[str] = []
        self._news = threading.Condition()
        parent = os.getpid()
        self.process = subprocess.Popen(
            list(map(str, command)),
            env=environment,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
            preexec_fn=lambda: _die_with(parent),
        )
        self._limit = threading.Timer(LONGEST_S, self.process.kill)
        self._limit.daemon = True
        self._limit.start()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._limit.cancel()
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self._reader.join()

    @property
    def output(self) -> str:
        """Return everything it has said."""
        return "\n".join(self.lines)

    def await_output(self, pattern: str, *, within_s: float = PATIENCE_S) -> str:
        """Wait for a line that matches; return it."""
        end_s = time.monotonic() + within_s
        with self._news:
            while not (found := [line for line in self.lines if re.search(pattern, line)]):
                left_s = end_s - time.monotonic()
                if self.process.poll() is not None and not self._reader.is_alive():
                    raise AssertionError(f"ended without {pattern!r}:\n{self.output}")
                if left_s <= 0.0:
                    raise AssertionError(f"no {pattern!r} within {within_s} s:\n{self.output}")
                self._news.wait(min(left_s, 0.1))
        return found[0]

    def until(self, condition: Callable[[], Any], *, within_s: float = PATIENCE_S) -> None:
        """Wait until a condition holds, while it runs."""
        end_s = time.monotonic() + within_s
        while not condition():
            if self.process.poll() is not None or time.monotonic() > end_s:
                raise AssertionError(f"nothing came of it:\n{self.output}")
            time.sleep(0.05)

    def stop(self, number: int = signal.SIGINT, *, within_s: float = PATIENCE_S) -> int:
        """Send a signal and return the exit code."""
        self.process.send_signal(number)
        return self.wait(within_s=within_s)

    def wait(self, *, within_s: float = PATIENCE_S) -> int:
        """Wait for the end and return the exit code."""
        try:
            code = self.process.wait(within_s)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"still running after {within_s} s:\n{self.output}") from None
        self._reader.join()
        return code

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as stdout:
            for line in stdout:
                with self._news:
                    self.lines.append(line.rstrip())
                    self._news.notify_all()


class NodeProcess(Program):
    """A node in a process of its own.

    Parameters
    ----------
    module
        What ``python -m`` runs.
    parameters
        Parameters by dotted name: plain values or parameter dataclasses.
    arguments
        Further ROS arguments.
    """

    def __init__(
        self,
        module: str,
        parameters: Mapping[str, Any] | None = None,
        *,
        arguments: Sequence[str] = (),
    ) -> None:
        words = _ros_arguments(parameters or {}, arguments)
        super().__init__([sys.executable, "-u", "-m", module, *words])


def refused(
    run: Callable[..., int], parameters: Mapping[str, Any], *, arguments: Sequence[str] = ()
) -> str:
    """Run a node in this process that ends at once, as by itself: with exit code 2, and one line,
    which is returned.
    """
    words, interval_s = _ros_arguments(parameters, arguments), sys.getswitchinterval()
    with contextlib.redirect_stderr(io.StringIO()) as said:
        try:
            code = run(args=words)
        finally:
            sys.setswitchinterval(interval_s)
    (line,) = said.getvalue().splitlines()
    assert code == 2, line
    return line


def _ros_arguments(parameters: Mapping[str, Any], arguments: Sequence[str]) -> list[str]:
    """Return the arguments of a node in this process's domain, with a file of parameters."""
    isolate()
    words = ["--ros-args", *arguments]
    if not parameters:
        return words
    folder = os.environ["ROS_LOG_DIR"]
    with tempfile.NamedTemporaryFile("w", dir=folder, suffix=".yaml", delete=False) as file:
        yaml.safe_dump(to_ros_yaml(parameters), file)
    return [*words, "--params-file", file.name]


def _die_with(parent: int) -> None:
    """Run in the child before it becomes the node: be killed when the test process dies."""
    _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)
