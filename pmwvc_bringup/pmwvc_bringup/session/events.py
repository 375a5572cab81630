# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The events of a live session: those that its runner sees, for the report and on the terminal,
and the disturbances that its scenario asks for, done to its nodes.
"""

import json
import signal
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from pmwvc_bringup.session.plan import NodePlan
from pmwvc_bringup.session.processes import Child, Children
from pmwvc_core.scenario.conflicts import Disturbance

STOPPED = "recorder: recording stopped"  # begin of the recorder's line when its disk is full


class Notes:
    """The events noted so far, and the texts of those that the status shows."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._events: list[dict[str, object]] = []
        self.shown: list[str] = []

    def note(self, who: str, kind: str, what: str, **more: object) -> None:
        """Note an event of now."""
        event = {"time_ns": time.time_ns(), "who": who, "kind": kind, "what": what, **more}
        self._events.append(event)

    def ended(self, child: Child) -> None:
        """Note the end of a node."""
        what = str(child).removeprefix(f"{child.name} ")
        self.note(child.name, "ended", what, code=child.code, signal=child.signal)
        self._console.print(f"{child}; its log: {child.log}")
        self.shown.append(str(child))

    def recording(self, recorder: Child) -> None:
        """Note, once, that the recorder has stopped recording."""
        lines = recorder.log_tail().splitlines()
        stopped = next((line for line in lines if line.startswith(STOPPED)), "")
        if stopped and all(event["kind"] != "recording" for event in self._events):
            self.note("recorder", "recording", stopped.removeprefix("recorder: "))
            self._console.print(stopped, markup=False)
            self.shown.append("recording stopped")

    def write(self, folder: Path) -> None:
        """Write ``events.json``."""
        text = json.dumps(self._events, indent=2) + "\n"
        try:
            (folder / "events.json").write_text(text, "utf-8")
        except OSError as error:
            self._console.print(f"events.json is not written: {error.strerror or error}")


def start_node(
    node: NodePlan, path: Path, children: Children, environment: Mapping[str, str]
) -> None:
    """Start a node; ``path`` is that of its files, without a suffix."""
    file = path.with_suffix(".yaml")
    file.write_text(node.parameter_file(), "utf-8")
    command, log = node.command(file), path.with_suffix(".log")
    children.start(node.name, command, env=environment, log=log)


LISTENERS = 2  # of a trace: the recorder, and the runner's monitor
SIGNALS = {"stop": signal.SIGSTOP, "continue": signal.SIGCONT}


class Disturber:
    """Kills, starts, stops and continues nodes of a session when it is time.

    ``wanted`` is in the order of time; ``note`` takes who, kind and what of each as an event.
    """

    def __init__(
        self,
        wanted: Sequence[Disturbance],
        *,
        nodes: Sequence[NodePlan],
        children: Children,
        environment: Mapping[str, str],
        logs: Path,
        note: Callable[[str, str, str], None],
    ) -> None:
        self._left, self._children, self._note = list(wanted), children, note
        self._nodes = {node.namespace or node.kind: node for node in nodes}
        self._environment, self._logs = environment, logs
        self._again = 0  # nodes that were started again

    def act(self, elapsed_s: float) -> None:
        """Do what is due."""
        while self._left and self._left[0].time_s <= elapsed_s:
            wanted = self._left.pop(0)
            if node := self._nodes.get(wanted.node):
                self._do(node, wanted.action)
                self._note(node.name, "disturbance", f"as the scenario asks: {wanted.action}")

    def _do(self, node: NodePlan, action: str) -> None:
        child = self._children.children[node.name]
        if action == "start" and not child.running:
            self._start(node)
        elif action != "start" and child.running:
            child.reported = action == "kill"
            child.process.send_signal(SIGNALS.get(action, signal.SIGKILL))
            if child.reported:
                child.process.wait()

    def _start(self, node: NodePlan) -> None:
        """Start a node again; it begins once its topics have found their other ends."""
        self._again += 1
        starts = {"start.paused": False, "start.joins": True, "start.listeners": LISTENERS}
        node = replace(node, parameters={**node.parameters, **starts})
        name = f"{node.file_name}_again{self._again}"
        start_node(node, self._logs / name, self._children, self._environment)
