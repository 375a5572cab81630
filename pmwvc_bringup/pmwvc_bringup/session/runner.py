# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A live session from its first process to its recording.

Recorder, network emulator, server and masters are started in this order; when all are connected,
they begin together. A node that ends is noted and the others go on. However the session ends, by
an error of the runner too, masters, server, emulator and recorder stop in this order: devices
first, and the last packets are still recorded.
"""

import os
import re
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.live import Live

from pmwvc_bringup import INTERRUPTS
from pmwvc_bringup.output import doing
from pmwvc_bringup.scenarios import to_yaml
from pmwvc_bringup.session import plan
from pmwvc_bringup.session.events import Disturber, Notes, start_node
from pmwvc_bringup.session.page import show
from pmwvc_bringup.session.processes import Children
from pmwvc_bringup.session.surroundings import node_environment, own_domain
from pmwvc_core.errors import PmwvcError
from pmwvc_core.runtime.interrupts import Interrupts
from pmwvc_core.runtime.token_files import write_session
from pmwvc_core.scenario.conflicts import disturbances_of
from pmwvc_core.scenario.scenario import Scenario

if TYPE_CHECKING:
    from pmwvc_bringup.session.monitor import Monitor

CONNECTION_TIMEOUT_S = 30.0  # until all nodes are connected; 1.5 s is usual
STATUS_PERIOD_S = 0.25
LINE_PERIOD_S = 2.0  # of status lines where there is no terminal
READY = "ready"


class StartError(PmwvcError):
    """A node of the session did not start; the message holds the last lines of its log."""


class NodeSession:
    """One session of real nodes, in a folder that exists and is empty.

    ``page`` is where its page is served (None: nowhere); ``browser``: whether it is opened where
    there is a desktop.
    """

    def __init__(
        self,
        scenario: Scenario,
        folder: Path,
        *,
        console: Console,
        page: plan.Page | None = None,
        browser: bool = False,
    ) -> None:
        self.scenario, self.folder, self.console, self.page = scenario, folder, console, page
        self.children, self.notes = Children(), Notes(console)
        self.interrupts = Interrupts()
        self.interrupts.count = len(INTERRUPTS)
        self._shown, self._browser = page is None, browser
        self.nodes: list[plan.NodePlan] = []
        self.topics = plan.topics(scenario)

    def run(self) -> bool:
        """Run the session; return whether it took place: False when it was interrupted before its
        nodes were connected. StartError where a node did not start.
        """
        logs = self.folder / "nodes"
        with self._writing():
            (self.folder / "scenario.yaml").write_text(to_yaml(self.scenario), "utf-8")
            logs.mkdir()
        with (
            self.interrupts.caught(),
            own_domain(os.environ) as domain,
            tempfile.TemporaryDirectory(prefix="pmwvc-tokens-") as tokens,  # for its owner only
        ):
            users = [user.name for user in self.scenario.users]
            write_session(Path(tokens), users)
            self.nodes = plan.nodes(
                self.scenario, folder=self.folder, tokens=Path(tokens), page=self.page
            )
            self.console.print(f"other ROS programs join this session with ROS_DOMAIN_ID={domain}")
            environment = node_environment(os.environ, domain=domain, log_folder=logs / "ros")
            try:
                with self._writing():  # the folder may be taken away meanwhile
                    for node in self.nodes:
                        start_node(node, logs / node.file_name, self.children, environment)
                # rclpy starts threads that a fork would copy half: only after the last child
                os.environ.update(environment)
                from pmwvc_bringup.session.monitor import watching

                with watching(users) as monitor:
                    with doing("connecting the nodes"):
                        begun = self._begin(monitor)
                    if begun:
                        disturber = Disturber(
                            disturbances_of(self.scenario.disturbances),
                            nodes=self.nodes,
                            children=self.children,
                            environment=environment,
                            logs=logs,
                            note=self.notes.note,
                        )
                        self._watch(monitor, disturber)
            finally:
                try:
                    with doing("ending the nodes"):
                        self._stop_nodes()
                finally:
                    self.children.kill()
                    self.notes.write(self.folder)
        return begun

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Raise a StartError where files cannot be written inside the block."""
        try:
            yield
        except OSError as error:
            why = f"{error.strerror or error}; choose another folder with --out"
            raise StartError(f"cannot write into {self.folder}: {why}") from None

    def _begin(self, monitor: "Monitor") -> bool:
        """Wait until every topic has its ends and each end has matched the others, then start;
        return False where the session was interrupted before.
        """
        recorder, logs = self.children.children["recorder"], self.folder / "nodes"
        names, groups = [node.ros_name for node in self.nodes], plan.start_order(self.nodes)
        until = time.monotonic() + CONNECTION_TIMEOUT_S
        while not self.interrupts.count:
            if ended := self.children.endings():
                lines = [*ended[0].log_tail().splitlines(), f"({ended[0].log})"]
                raise StartError("\n  ".join([f"{ended[0]} before the session began", *lines]))
            missing = monitor.unconnected(names, self.topics)
            if not missing and not recorder.has_logged(READY):
                missing = ["recorder: not ready"]
            if not missing and not (missing := monitor.start(groups)):
                return True
            if time.monotonic() > until:
                within, left = f"{CONNECTION_TIMEOUT_S:g} s", "; ".join(missing)
                text = f"the nodes have not found each other within {within}: {left}\nlogs: {logs}"
                raise StartError(f"{text}; 'pmwvc doctor' examines the machine")
            time.sleep(0.02)
        return False

    def _watch(self, monitor: "Monitor", disturber: Disturber) -> None:
        """Watch the running session until its time is over or it is interrupted."""
        begin, length = time.monotonic(), self.scenario.duration_s
        status_at, line_at = begin, begin + LINE_PERIOD_S / 2
        with Live(console=self.console, auto_refresh=False, transient=True) as live:
            while (now := time.monotonic()) < begin + length and not self.interrupts.count:
                disturber.act(now - begin)
                for child in self.children.endings():
                    self.notes.ended(child)
                if not self.children.running():
                    return
                if not self._shown:
                    self._show_page()
                if now >= status_at:
                    status_at += STATUS_PERIOD_S
                    self.notes.recording(self.children.children["recorder"])
                    parts = [f"{now - begin:6.1f} / {length:g} s", *monitor.status()]
                    line = " | ".join(parts + self.notes.shown)
                    if self.console.is_terminal:
                        live.update(line, refresh=True)
                    elif now >= line_at:
                        line_at += LINE_PERIOD_S
                        self.console.print(line, highlight=False, soft_wrap=True)
                time.sleep(max(min(0.05, begin + length - now), 0.0))
        if self.interrupts.count:
            self.console.print("ending the session")

    def _show_page(self) -> None:
        """Print the page's address, and open it, once its server has said it."""
        output = self.children.children["view"].log_tail(lines=1000)
        if found := re.search(r"^page (.*)$", output, re.MULTILINE):
            self._shown = True
            show(found[1], self.console, browser=self._browser)

    def _stop_nodes(self) -> None:
        """End the nodes in an order in which the last packets are still recorded."""
        first = self.interrupts.count
        for kind in ("view", "master", "server", "netem", "recorder"):
            names = [node.name for node in self.nodes if node.kind == kind]
            failed = self.children.stop(names, hurried=lambda: self.interrupts.count > first)
            for child in [*failed, *self.children.endings()]:
                self.notes.ended(child)
