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
    """The events noted so far."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._events: list[dict[str, object]] = []

    def note(self, who: str, kind: str, what: str, **more: object) -> None:
        """Note an event of now."""
        event = {"time_ns": time.time_ns(), "who": who, "kind": kind, "what": what, **more}
        self._events.append(event)

    def _noted(self, what: str) -> bool:
        return any(event["what"] == what for event in self._events)

    def ended(self, child: Child) -> None:
        """Note the end of a node."""
        what = str(child).removeprefix(f"{child.name} ")
        self.note(child.name, "ended", what, code=child.code, signal=child.signal)
        self._console.print(f"{child}; its log: {child.log}")

    def recording_stopped(self, recorder: Child) -> list[str]:
        """Note, once, that the recorder has stopped recording, and return it as a text."""
        lines = recorder.log_tail().splitlines()
        stopped = next((line for line in lines if line.startswith(STOPPED)), "")
        if not stopped or self._noted(what := stopped.removeprefix("recorder: ")):
            return []
        self.note("recorder", "recording", what)
        self._console.print(stopped, markup=False)
        return ["recording stopped"]

    def stranger(self, topic: str, what: str) -> list[str]:
        """Note, once, publishers that do not belong to the session; return them as a text."""
        if self._noted(what):
            return []
        self.note(topic, "stranger", what)
        self._console.print(f"Warning: {what}", markup=False)
        return [what]

    def write(self, folder: Path) -> None:
        """Write ``events.json``."""
        try:
            text = json.dumps(self._events, indent=2) + "\n"
            (folder / "events.json").write_text(text, "utf-8")
        except OSError as error:
            self._console.print(f"events.json is not written: {error.strerror or error}")


LISTENERS = 2  # of a trace: the recorder, and the runner's monitor
SIGNALS = {"stop": signal.SIGSTOP, "continue": signal.SIGCONT}


class Disturber:
    """Kills, starts, stops and continues nodes of a session when it is time.

    ``wanted`` is in the order of time; ``note`` takes who, kind and what of each as an event.

    Attributes
    ----------
    again
        Names in the ROS graph of the nodes that were started again.
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
        self._left = list(wanted)
        self._nodes = {node.namespace or node.kind: node for node in nodes}
        self._children = children
        self._environment = environment
        self._logs = logs
        self._note = note
        self.again: list[str] = []

    def act(self, elapsed_s: float) -> None:
        """Do what is due."""
        while self._left and self._left[0].time_s <= elapsed_s:
            self._do(self._left.pop(0))

    def _do(self, wanted: Disturbance) -> None:
        node = self._nodes.get(wanted.node)
        if node is None:
            return
        child = self._children.children[node.name]
        if wanted.action == "start":
            if not child.running:
                self._start(node)
        elif child.running:
            child.reported = wanted.action == "kill"
            child.process.send_signal(SIGNALS.get(wanted.action, signal.SIGKILL))
            if child.reported:
                child.process.wait()
        what = f"as the scenario asks: {wanted.action}"
        self._note(node.name, "disturbance", what)

    def _start(self, node: NodePlan) -> None:
        """Start a node again; it begins once its topics have found their other ends."""
        self.again.append(node.ros_name)
        starts = {"start.paused": False, "start.joins": True, "start.listeners": LISTENERS}
        node = replace(node, parameters={**node.parameters, **starts})
        name = f"{node.file_name}_again{len(self.again)}"
        file = self._logs / f"{name}.yaml"
        file.write_text(node.parameter_file(), "utf-8")
        command = node.command(file)
        log = self._logs / f"{name}.log"
        self._children.start(node.name, command, env=self._environment, log=log)
