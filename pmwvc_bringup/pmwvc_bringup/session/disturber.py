# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The disturbances of a live session at work: what its scenario asks to be done to its nodes."""

import signal
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from pmwvc_bringup.session.plan import NodePlan
from pmwvc_bringup.session.processes import Children
from pmwvc_core.scenario.disturbances import Disturbance

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
