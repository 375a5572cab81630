# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A live session from its first process to its recording.

Recorder, network emulator, server and masters are started in this order; when all have met, they
are told to begin. A node that dies is noted and the others go on. On every way out, an error of
the runner itself included, masters, server, emulator and recorder stop in this order: devices
first, and what is sent last is still recorded.
"""

import json
import os
import time
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.live import Live

from pmwvc_bringup.scenarios import to_yaml
from pmwvc_bringup.session import plan
from pmwvc_bringup.session.interrupts import Interrupts
from pmwvc_bringup.session.processes import Children, Ending
from pmwvc_bringup.session.status import Status
from pmwvc_bringup.session.surroundings import node_environment, own_domain
from pmwvc_core.errors import PmwvcError
from pmwvc_core.scenario.scenario import Scenario

MEETING_S = 30.0  # patience until all nodes have met; 1.5 s is usual
GLANCE_S = 0.25
BEGINNING_S = 3.0
LINE_S = 2.0  # between two lines where there is no terminal
STRANGERS_S = 1.0  # between two looks for publishers that do not belong to the session
READY = "ready"
STOPPED = "recorder: recording stopped"  # begin of what the recorder says when its disk is full


class StartError(PmwvcError):
    """A node of the session never came up; the message holds its last words."""


class LiveSession:
    """One session of real nodes.

    Parameters
    ----------
    scenario
        What to run.
    folder
        The session folder; it exists and is empty.
    console
        Where words for people go.
    """

    def __init__(self, scenario: Scenario, folder: Path, *, console: Console) -> None:
        self.scenario = scenario
        self.folder = folder
        self.console = console
        self.children = Children()
        self.events: list[dict[str, Any]] = []
        self.interrupts = Interrupts()
        self.nodes = plan.nodes(scenario, folder=folder, paused=True)
        self.ends = plan.topic_ends(scenario)

    def run(self) -> bool:
        """Run the session; tell whether it took place.

        Returns False when it was interrupted before its nodes had met.

        Raises
        ------
        StartError
            If a node did not come up.
        """
        try:
            (self.folder / "scenario.yaml").write_text(to_yaml(self.scenario), "utf-8")
            (self.folder / "nodes").mkdir()
        except OSError as error:
            raise StartError(
                f"cannot write into {self.folder}: {error.strerror or error}; "
                "choose another folder with --out"
            ) from None
        with self.interrupts.caught(), own_domain(os.environ) as domain:
            self.console.print(f"other ROS programs join this session with ROS_DOMAIN_ID={domain}")
            logs = self.folder / "nodes"
            environment = node_environment(os.environ, domain=domain, log_folder=logs / "ros")
            try:
                self._start_nodes(logs, environment)
                # rclpy starts threads that a fork would copy half: only after the last child
                os.environ.update(environment)
                from pmwvc_bringup.session.monitor import watching

                with watching([user.name for user in self.scenario.users]) as monitor:
                    met = self._met(monitor)
                    if met:
                        self._attend(monitor)
            finally:
                try:
                    self._stop_nodes()
                finally:
                    self.children.kill()
                    self._write_events()
        return met

    def _write_events(self) -> None:
        try:
            text = json.dumps(self.events, indent=2) + "\n"
            (self.folder / "events.json").write_text(text, "utf-8")
        except OSError as error:
            self.console.print(f"events.json is not written: {error.strerror or error}")

    def _start_nodes(self, logs: Path, environment: dict[str, str]) -> None:
        for node in self.nodes:
            file = logs / f"{node.file_name}.yaml"
            file.write_text(node.parameter_file(), "utf-8")
            log = logs / f"{node.file_name}.log"
            self.children.start(node.name, node.command(file), env=environment, log=log)

    def _met(self, monitor: Any) -> bool:
        """Wait until every topic has its ends and each end has matched the others, then start."""
        ends = self.ends
        names = [node.ros_name for node in self.nodes]
        recorder = self.children.children["recorder"]
        until = time.monotonic() + MEETING_S
        while True:
            if self.interrupts.count:
                return False
            if ended := self.children.endings():
                raise StartError(f"{ended[0]} before the session began\n{self._words(ended[0])}")
            missing = monitor.missing(ends)
            if not missing and not recorder.says(READY):
                missing = ["recorder: not ready"]
            if not missing and not (missing := monitor.unmatched(names, ends)):
                break
            if time.monotonic() > until:
                raise StartError(
                    f"the nodes have not found each other within {MEETING_S:g} s: "
                    f"{'; '.join(missing)}\n"
                    f"logs: {self.folder / 'nodes'}; 'pmwvc doctor' examines the machine"
                )
            time.sleep(0.02)
        for kind in ("netem", "server", "master"):  # nobody speaks before there is who listens
            monitor.start([node.ros_name for node in self.nodes if node.kind == kind])
        # The session's time counts from here, so that every loop has run for all of it.
        until = time.monotonic() + BEGINNING_S
        while not monitor.all_ticking() and time.monotonic() < until:
            time.sleep(0.01)
        return True

    def _words(self, ending: Ending) -> str:
        """Return the last lines of a node's log, indented."""
        child = self.children.children[ending.name]
        return "\n".join(f"  {line}" for line in child.log_tail().splitlines()) + (
            f"\n  ({child.log})"
        )

    def _attend(self, monitor: Any) -> None:
        """Watch the running session until its time is over or somebody wants it to end."""
        begin = time.monotonic()
        length = self.scenario.duration_s
        ended: list[str] = []
        glance_at, line_at, strangers_at = begin, begin + LINE_S / 2, begin
        with Live(console=self.console, auto_refresh=False, transient=True) as live:
            while (now := time.monotonic()) < begin + length and not self.interrupts.count:
                for ending in self.children.endings():
                    self._note(ending)
                    ended.append(str(ending))
                if not self.children.running():
                    return
                if now >= strangers_at:
                    strangers_at += STRANGERS_S
                    ended += self._strangers(monitor)
                if now >= glance_at:
                    glance_at += GLANCE_S
                    if stopped := self._recording_stopped():
                        ended.append(stopped)
                    status = Status(now - begin, length, monitor.glance(), ended)
                    if self.console.is_terminal:
                        live.update(status.table(), refresh=True)
                    elif now >= line_at:
                        line_at += LINE_S
                        self.console.print(status.line(), highlight=False, soft_wrap=True)
                time.sleep(max(min(0.05, begin + length - now), 0.0))
        if self.interrupts.count:
            self.console.print("ending the session")

    def _stop_nodes(self) -> None:
        """End the nodes so that what the others send last is still recorded."""
        first = self.interrupts.count
        for kind in ("master", "server", "netem", "recorder"):
            names = [node.name for node in self.nodes if node.kind == kind]
            endings = self.children.stop(names, hurried=lambda: self.interrupts.count > first)
            for ending in [*endings, *self.children.endings()]:
                self._note(ending)

    def _recording_stopped(self) -> str | None:
        """Note, once, that the recorder records no more, and return it in words."""
        lines = self.children.children["recorder"].log_tail().splitlines()
        said = next((line for line in lines if line.startswith(STOPPED)), "")
        what = said.removeprefix("recorder: ")
        if not said or any(event["what"] == what for event in self.events):
            return None
        event = {"time_ns": time.time_ns(), "who": "recorder", "kind": "recording", "what": what}
        self.events.append(event)
        self.console.print(said, markup=False)
        return "recording stopped"

    def _strangers(self, monitor: Any) -> list[str]:
        """Note every publisher that does not belong to the session, once; return them in words."""
        found = []
        for topic, what in monitor.strangers(self.ends).items():
            if any(event["what"] == what for event in self.events):
                continue
            event = {"time_ns": time.time_ns(), "who": topic, "kind": "stranger", "what": what}
            self.events.append(event)
            self.console.print(f"Warning: {what}", markup=False)
            found.append(what)
        return found

    def _note(self, ending: Ending) -> None:
        """Keep how a node ended, for the report."""
        self.events.append(
            {
                "time_ns": time.time_ns(),
                "who": ending.name,
                "kind": "ended",
                "what": str(ending).removeprefix(f"{ending.name} "),
                "code": ending.code,
                "signal": ending.signal,
            }
        )
        self.console.print(f"{ending}; its log: {self.children.children[ending.name].log}")
